// A voxel of level 0 that reflects what the coarse voxel around it receives (receive.wgsl).
{{ use("techniques/voxel_cones/octree/octree.wgsl") }}
{{ use("techniques/voxel_cones/bricks/facing.wgsl") }}
{{ use("techniques/voxel_cones/voxels/voxel.wgsl") }}
{{ use("techniques/voxel_cones/bricks/bright.wgsl") }}

// coarse: code of the coarse voxel.  occupied: the voxel is; else `surface` is another's.  facing: two words (facing.wgsl).
struct Reflector { coarse: u32, occupied: bool, surface: VoxelSurface, facing: vec2u }

fn reflector_at(node: u32, corner: u32) -> Reflector {
    let leaf = load_leaves(node - bounce.first_leaf);
    let number = (leaf >> 8u) + countOneBits(leaf & ((1u << corner) - 1u));
    return Reflector(
        (8u * codes[node] + corner) >> {{ 3 * level }}u, ((leaf >> corner) & 1u) == 1u, unpack_surface(load_voxels(number)),
        facing[8u * node + corner],
    );
}

// What arrives at a side of a coarse voxel, and what further bounces would bring, where that is added.
fn arriving_at(side: u32) -> vec3f {
    let now = unpack_bright(received[bounce.now + side]);
    if bounce.endless == 0.0 { return now; }
    return now + series[0].gain * max(now - unpack_bright(received[bounce.before + side]), vec3f(0.0));
}
