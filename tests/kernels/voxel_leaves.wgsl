// Which voxel of level 0 points of surfaces lie in: node, corner, number of its record, and whether there is one.
{{ use("techniques/voxel_cones/octree/leaves.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= {{ count }}u { return; }
    let found = leaf_of_surface(to_voxels(given[2u * id.x].xyz), given[2u * id.x + 1u].xyz);
    let some = found.node != NO_NODE;
    result[id.x] = vec4u(select(0u, found.node, some), found.corner, found.number, select(0u, 1u, some));
}
