// Test kernel: the sRGB encoding of a colour, and every tone map of it.
{{ use("shaders/tonemap.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= {{ threads }}u { return; }
    let color = vec3f(given[3u * id.x], given[3u * id.x + 1u], given[3u * id.x + 2u]);
    let first = {{ 3 + 3 * functions|length }}u * id.x;
    let encoded = srgb_encode(color);
    for (var k = 0u; k < 3u; k++) { result[first + k] = encoded[k]; }
    {% for function in functions %}
    let mapped_{{ loop.index }} = {{ function }}(color);
    for (var k = 0u; k < 3u; k++) { result[first + {{ 3 * loop.index }}u + k] = mapped_{{ loop.index }}[k]; }
    {% endfor %}
}
