// Light, or emission, as a share of the brightest there is: 9 bits each for r, g and b, with a common exponent.

fn pack_bright(color: vec3f) -> u32 {
    let largest = max(max(color.r, color.g), color.b);
    let exponent = clamp(i32(ceil(log2(max(largest, 1e-30) * {{ 512 / 511 }}))), -31, 0);
    let codes = vec3u(min(round(color * exp2(f32(9 - exponent))), vec3f(511.0)));
    return codes.x | (codes.y << 9u) | (codes.z << 18u) | (u32(exponent + 31) << 27u);
}

fn unpack_bright(packed: u32) -> vec3f {
    let codes = vec3u(packed, packed >> 9u, packed >> 18u) & vec3u(511u);
    return vec3f(codes) * bitcast<f32>(((packed >> 27u) + 87u) << 23u); // 2^(code - 40): 87 is 127 - 40
}
