// Moments of light: signed numbers as shares of the brightest light there is, 9 bits each with a common exponent, as in
// bright.wgsl.

fn pack_moment(moment: vec3f) -> u32 {
    let largest = max(max(abs(moment.x), abs(moment.y)), abs(moment.z));
    let exponent = clamp(i32(ceil(log2(max(largest, 1e-30) * {{ 256 / 255 }}))), -31, 0);
    let codes = vec3u(vec3i(clamp(round(moment * exp2(f32(8 - exponent))), vec3f(-255.0), vec3f(255.0))) + 256);
    return codes.x | (codes.y << 9u) | (codes.z << 18u) | (u32(exponent + 31) << 27u);
}

fn unpack_moment(packed: u32) -> vec3f {
    let codes = vec3i(vec3u(packed, packed >> 9u, packed >> 18u) & vec3u(511u)) - 256;
    let moment = vec3f(codes) * bitcast<f32>(((packed >> 27u) + 88u) << 23u); // 2^(code - 39): 88 is 127 - 39
    return select(moment, vec3f(0.0), packed == 0u); // what nothing was written to
}
