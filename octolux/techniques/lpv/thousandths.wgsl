// Three numbers from 0 to 1 in the 10-bit fields of a word, in steps of 1/1023 (simulator/lpv/formats.py).

fn pack_thousandths(x: vec3f) -> u32 {
    let steps = vec3u(round(x * 1023.0));
    return steps.x | (steps.y << 10u) | (steps.z << 20u);
}

fn unpack_thousandths(word: u32) -> vec3f {
    // Signed: a CPU converts these in one instruction, and all are below 2^30.
    return vec3f(vec3i(vec3u(word, word >> 10u, word >> 20u) & vec3u(1023u))) * {{ 1 / 1023 }};
}
