// Test kernel: the tone map of a colour, and its sRGB encoding.
{{ use("shaders/tonemap.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= {{ threads }}u { return; }
    let color = vec3f(given[3u * id.x], given[3u * id.x + 1u], given[3u * id.x + 2u]);
    let mapped = neutral_tone_map(color);
    let encoded = srgb_encode(color);
    for (var k = 0u; k < 3u; k++) {
        result[6u * id.x + k] = mapped[k];
        result[6u * id.x + 3u + k] = encoded[k];
    }
}
