// Blended surfaces by stochastic transparency (Enderton et al. 2010): a surface is kept with a probability equal to its
// alpha. Averaged over the samples of a pixel that is the blend of all layers in their right order.

// PCG in three dimensions (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering").
fn lattice_bits(cell: vec3i) -> vec3u {
    var v = bitcast<vec3u>(cell) * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> vec3u(16u);
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    return v;
}

// 24 bits as a number in [0, 1).
fn unit_interval(bits: u32) -> f32 { return f32(bits >> 8u) / 16777216.0; }
fn lattice_hash(cell: vec3i) -> f32 { return unit_interval(lattice_bits(cell).x); }

// A threshold in [0, 1) for each point of space, even over pixels and stable under motion, for pictures of one sample
// (Wyman and McGuire 2017, "Hashed Alpha Testing", listing 1). Call it in uniform control flow: it takes derivatives.
fn hashed_threshold(p: vec3f) -> f32 {
    let step = max(length(dpdx(p)), length(dpdy(p)));
    let log_scale = -log2(max(step, 1e-20));
    let fine = fract(log_scale);
    let scale = exp2(floor(log_scale));
    let coarse_hash = lattice_hash(vec3i(floor(scale * p)));
    let fine_hash = lattice_hash(vec3i(floor(2.0 * scale * p)));
    let x = mix(coarse_hash, fine_hash, fine);
    // A mix of two uniform numbers is not uniform: back through its cumulative distribution.
    let a = min(fine, 1.0 - fine);
    let rest = 2.0 * a * (1.0 - a);
    var even = (x - 0.5 * a) / (1.0 - a);
    if x < a { even = x * x / rest; }
    if x >= 1.0 - a { even = 1.0 - (1.0 - x) * (1.0 - x) / rest; }
    return clamp(even, 0.0, 0.999999);
}

// Place of `i` in permutation number `pattern` of 0 to count - 1 (Kensler 2013, "Correlated Multi-Jittered Sampling").
fn permuted(i: u32, count: u32, pattern: u32) -> u32 {
    let mask = (2u << firstLeadingBit(max(count - 1u, 1u))) - 1u;
    var x = i;
    loop {
        x = (x ^ pattern) * 0xe170893du;
        x ^= pattern >> 16u;
        x ^= (x & mask) >> 4u;
        x = (x ^ (pattern >> 8u)) * 0x0929eb3fu;
        x ^= pattern >> 23u;
        x ^= (x & mask) >> 1u;
        x *= 1u | (pattern >> 27u);
        x *= 0x6935fa69u;
        x ^= (x & mask) >> 11u;
        x *= 0x74dcb303u;
        x ^= (x & mask) >> 2u;
        x *= 0x9e501cc3u;
        x ^= (x & mask) >> 2u;
        x *= 0xc860a3dfu;
        x &= mask;
        x ^= x >> 5u;
        if x < count { break; }
    }
    return (x + pattern % count) % count;
}

// The same for one of many samples of a pixel: each surface has a threshold in every one of `samples` equal parts of
// [0, 1), so that its mean has little noise, in an order of its own, so that layers are independent of each other.
fn sample_threshold(pixel: vec2f, surface: u32, sample: u32, samples: u32) -> f32 {
    let bits = lattice_bits(vec3i(vec2i(pixel), i32(surface)));
    let part = f32(permuted(sample, samples, bits.y)) + unit_interval(bits.x);
    return min(part / f32(samples), 0.999999);
}
