// Blended surfaces by stochastic transparency (Enderton et al. 2010): a surface is kept with a probability equal to its
// alpha. Averaged over the samples of a pixel that is the blend of all layers in their right order.

// PCG in three dimensions (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering"), in [0, 1).
fn lattice_hash(cell: vec3i) -> f32 {
    var v = bitcast<vec3u>(cell) * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> vec3u(16u);
    v.x += v.y * v.z;
    return f32(v.x >> 8u) / 16777216.0;
}

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

// The same for one of many samples of a pixel: `shift` is even over the samples, so that their mean has little noise; the
// number of the surface's cluster keeps layers apart.
fn sample_threshold(pixel: vec2f, cluster: u32, shift: f32) -> f32 {
    return fract(lattice_hash(vec3i(vec2i(pixel), i32(cluster))) + shift);
}
