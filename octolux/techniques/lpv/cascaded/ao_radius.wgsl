// How far ambient occlusion looks (frame/ambient_occlusion.py): half a cell of the grids that light is read from there, by their
// shares. Cells that are looked up lie so far before their surfaces on average: what is nearer is not in their light.
{{ use("techniques/lpv/reading.wgsl") }}

fn ao_radii(position: vec3f, normal: vec3f) -> Radii {
    let reading = reading_at(position, {{ lookup_offset }} * normal);
    let next = grids[min(reading.window + 1u, {{ windows - 1 }}u)].cell_size;
    return Radii(0.5 * grids[reading.window].cell_size, 0.5 * next, reading.share);
}
