// Opacity along x, y and z in one word, 10 bits each: levels are made of each other without adding up their rounding.

fn pack_opacity(o: vec3f) -> u32 {
    let codes = vec3u(round(saturate(o) * 1023.0));
    return codes.x | (codes.y << 10u) | (codes.z << 20u);
}

fn unpack_opacity(packed: u32) -> vec3f {
    return vec3f(vec3u(packed, packed >> 10u, packed >> 20u) & vec3u(1023u)) / 1023.0;
}
