// Light of what does not move, from the octree of what is static: of all voxels but those of level 0 in nodes that something
// that moves lies in. What is made of these is averaged afterwards. A thread for each of the eight voxels of a brick's node.
{{ use("techniques/voxel_cones/octree/octree.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + {{ row }}u * id.y;
    if index >= 8u * parameters.count { return; }
    let owner = owners[index >> 3u];
    let node = owner >> 3u;
    let leaf = load_leaves(select(0u, node - parameters.first, node >= parameters.first));
    if node >= parameters.first && (leaf & 255u) != 0u { return; }
    let other = static_node_of(codes[node]);
    let brick = select(NO_NODE, brick_of_way(static_ways[select(other, 0u, other == NO_NODE)], owner & 7u), other != NO_NODE);
    light[index] = select(0u, static_light[8u * select(brick, 0u, brick == NO_NODE) + (index & 7u)], brick != NO_NODE);
}
