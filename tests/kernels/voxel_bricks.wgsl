// What `sample_voxels` finds at points in voxels of level 0, on a level, along directions; and whether there is nothing.
{{ use(file) }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= {{ count }}u { return; }
    let at = given[2u * id.x];
    result[2u * id.x] = sample_voxels(at.xyz, u32(at.w), given[2u * id.x + 1u].xyz);
    result[2u * id.x + 1u] = vec4f(select(0.0, 1.0, is_empty(at.xyz, u32(at.w))));
}
