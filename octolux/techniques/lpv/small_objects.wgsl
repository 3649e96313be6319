// How much of a VPL's light goes into a cell: of an object smaller than the cell less than all, or nothing
// (simulator/lpv/injection.py, `small_object_share`).
{{ use("shaders/traits.wgsl") }}

fn kept_share(vpl: u32, cell: u32) -> f32 {
    let traits = unpack_traits(load_surfaces(vpl));
    let cell_size = inverseSqrt(per_cross_section(cell));
    let share = smoothstep(0.5 * cell_size, cell_size, traits.size);
    return {% if small_objects == "fade moving" %}select(1.0, share, traits.moving){% else %}share{% endif %};
}
