// A voxel of level 0 in 16 bytes: square roots of the albedo as 8 bits; six shares of its sections that surfaces facing
// +x, -x, +y, -y, +z, -z cover, 8 bits; and emission as a share of the scene's brightest, 9 bits with a common exponent.
{{ use("techniques/voxel_cones/bricks/bright.wgsl") }}

struct VoxelSurface { albedo: vec3f, facing_up: vec3f, facing_down: vec3f, emission: vec3f }

fn pack_surface(s: VoxelSurface) -> Voxel {
    return Voxel(
        pack4x8unorm(vec4f(sqrt(s.albedo), 0.0)), pack4x8unorm(vec4f(s.facing_up, 0.0)),
        pack4x8unorm(vec4f(s.facing_down, 0.0)), pack_bright(s.emission),
    );
}

fn unpack_surface(v: Voxel) -> VoxelSurface {
    let root = unpack4x8unorm(v.albedo).rgb;
    return VoxelSurface(root * root, unpack4x8unorm(v.facing_up).xyz, unpack4x8unorm(v.facing_down).xyz, unpack_bright(v.emission));
}
