// Test kernel: thresholds of a blended surface in the samples of a pixel.
{{ use("shaders/hashed_alpha.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= {{ threads }}u { return; }
    let pixel = vec2f(given[3u * id.x], 0.5);
    let sample = u32(given[3u * id.x + 2u]);
    result[id.x] = sample_threshold(pixel, u32(given[3u * id.x + 1u]), sample, {{ samples }}u);
}
