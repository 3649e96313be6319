// Light that voxels of level 0 send: what was injected, and what they reflect of what the coarse voxels around them receive
// on the same side (receive.wgsl). A thread for each of the eight voxels of a brick's node.
{{ use("techniques/voxel_cones/octree/octree.wgsl") }}
{{ use("techniques/voxel_cones/bricks/facing.wgsl") }}
{{ use("techniques/voxel_cones/voxels/voxel.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + {{ row }}u * id.y;
    if index >= 8u * bounce.count { return; }
    let place = 8u * bounce.first + index;
    let owner = owners[place >> 3u];
    let corner = index & 7u;
    let way = owner & 7u;
    let node = owner >> 3u;
    let code = (8u * codes[node] + corner) >> {{ 3 * level }}u; // of the coarse voxel
    let brick = brick_of_way(ways[node_of(code >> 3u)], way);
    let leaf = load_leaves(node - bounce.first_leaf);
    let there = ((leaf >> corner) & 1u) == 1u && brick != NO_NODE;
    let voxel = unpack_surface(load_voxels((leaf >> 8u) + countOneBits(leaf & ((1u << corner) - 1u))));
    let arriving = unpack_bright(received[select(0u, 8u * (brick - bounce.coarse_first) + (code & 7u), there)]);
    let share = share_of_way(facing[8u * node + corner], way);
    light[place] = pack_bright(unpack_bright(injected_light[index]) + select(vec3f(0.0), share * voxel.albedo * arriving, there));
}
