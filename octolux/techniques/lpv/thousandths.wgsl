// Three numbers from 0 to 1 in the 10-bit fields of a word, in steps of 1/1023 (simulator/lpv/formats.py).

fn pack_steps(steps: vec3u) -> u32 { return steps.x | (steps.y << 10u) | (steps.z << 20u); }

fn pack_thousandths(x: vec3f) -> u32 { return pack_steps(vec3u(round(x * 1023.0))); }

fn unpack_thousandths(word: u32) -> vec3f {
    // Signed: a CPU converts these in one instruction, and all are below 2^30.
    return vec3f(vec3i(vec3u(word, word >> 10u, word >> 20u) & vec3u(1023u))) * {{ 1 / 1023 }};
}

// What passes of what is `blocked`, of which the part of surfaces across the face's own axis, which is blocked `straight` on,
// is not rounded to more than the whole: bounces take the rest of it for surfaces across the way.
fn pack_passing(blocked: vec3f, straight: f32) -> u32 {
    let least = round(straight * 1023.0) * {{ 5 ** -0.5 }};
    return pack_steps(1023u - vec3u(max(round(blocked * 1023.0), vec3f(ceil(least)))));
}
