// How far ambient occlusion looks (frame/ambient_occlusion.py): half a cell of the grids that light is read from there. Cells
// that are looked up lie so far before their surfaces on average: what is nearer is not in their light.
{{ use("techniques/lpv/reading.wgsl") }}

fn ao_radius(position: vec3f) -> f32 {
    let reading = reading_at(position, vec3f(0.0));
    let own = grids[reading.window].cell_size;
    return 0.5 * mix(grids[min(reading.window + 1u, {{ windows - 1 }}u)].cell_size, own, reading.share);
}
