// What the eight voxels of each node face, from the octree of what is static: so it stays where nothing moves.
{{ use("techniques/voxel_cones/octree/octree.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + {{ row }}u * id.y;
    if index >= 8u * parameters.count { return; }
    let other = static_node_of(codes[index >> 3u]);
    facing[index] = select(vec2u(0u), static_facing[8u * select(other, 0u, other == NO_NODE) + (index & 7u)], other != NO_NODE);
}
