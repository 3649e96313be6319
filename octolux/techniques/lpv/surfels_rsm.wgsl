// Surfels of a light's RSM: every texel that meets a surface, lit or black.
{{ use("shaders/octahedral.wgsl") }}
{{ use("techniques/lpv/surfel.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let number = id.y * surfels.row + id.x;
    if number >= surfels.count || id.x >= surfels.row { return; }
    let vpl = vpls[surfels.first + number];
    if vpl.area > 0.0 { add_surfel(vpl.position, unpack_unit_vector(vpl.normal), vpl.area); }
}
