// A voxel of level 0 in 16 bytes: square roots of the albedo as 8 bits; six shares of its sections that surfaces facing
// +x, -x, +y, -y, +z, -z cover, 8 bits; and emission as a share of the scene's brightest, 9 bits with a common exponent.

struct VoxelSurface { albedo: vec3f, facing_up: vec3f, facing_down: vec3f, emission: vec3f }

fn pack_bright(color: vec3f) -> u32 {
    let largest = max(max(color.r, color.g), color.b);
    let exponent = clamp(i32(ceil(log2(max(largest, 1e-30) * {{ 512 / 511 }}))), -31, 0);
    let codes = vec3u(min(round(color * exp2(f32(9 - exponent))), vec3f(511.0)));
    return codes.x | (codes.y << 9u) | (codes.z << 18u) | (u32(exponent + 31) << 27u);
}

fn unpack_bright(packed: u32) -> vec3f {
    let codes = vec3u(packed, packed >> 9u, packed >> 18u) & vec3u(511u);
    return vec3f(codes) * exp2(f32(packed >> 27u) - 40.0);
}

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
