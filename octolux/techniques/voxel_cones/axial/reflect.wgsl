// Light that voxels of level 0 send: what was injected, and what they reflect of what the coarse voxels around them receive
// on the same side (receive.wgsl). A thread for each of the eight voxels of a brick's node.
{{ use("techniques/voxel_cones/light/reflector.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + {{ row }}u * id.y;
    if index >= 8u * bounce.count { return; }
    let place = 8u * bounce.first + index;
    let owner = owners[place >> 3u];
    let way = owner & 7u;
    let voxel = reflector_at(owner >> 3u, index & 7u);
    let brick = brick_of_way(ways[node_of(voxel.coarse >> 3u)], way);
    let there = voxel.occupied && brick != NO_NODE;
    let arriving = arriving_at(select(0u, 8u * (brick - bounce.coarse_first) + (voxel.coarse & 7u), there));
    let share = share_of_way(voxel.facing, way);
    light[place] = pack_bright(unpack_bright(injected_light[index]) + select(vec3f(0.0), share * voxel.surface.albedo * arriving, there));
}
