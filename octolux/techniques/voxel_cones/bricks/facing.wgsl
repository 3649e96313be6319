// What faces +x, +y, +z and -x, -y, -z of a voxel's sections, 10 bits each: levels are made of each other without adding up
// the rounding of their bricks. 1/1023, less than half a step of a brick's texels, is nothing: what faces a way has a brick.

fn pack_shares(shares: vec3f) -> u32 {
    let rounded = vec3u(round(saturate(shares) * 1023.0));
    let codes = select(rounded, vec3u(0u), rounded == vec3u(1u));
    return codes.x | (codes.y << 10u) | (codes.z << 20u);
}

fn unpack_shares(packed: u32) -> vec3f {
    return vec3f(vec3u(packed, packed >> 10u, packed >> 20u) & vec3u(1023u)) / 1023.0;
}

// The share that faces one of simulator/voxels/surfaces.DIRECTIONS.
fn share_of_way(packed: vec2u, way: u32) -> f32 {
    return share_of(select(packed.y, packed.x, (way & 1u) == 0u), way >> 1u);
}

// The share across an axis, of one of the two words.
fn share_of(word: u32, axis: u32) -> f32 { return f32((word >> (10u * axis)) & 1023u) * {{ 1 / 1023 }}; }
