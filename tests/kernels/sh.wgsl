// Test kernel: given coefficients and a direction; the function there, the cosine lobe, the dominant lobe.
{{ use("shaders/sh.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= {{ threads }}u { return; }
    let i = 7u * id.x;
    let c = vec4f(given[i], given[i + 1u], given[i + 2u], given[i + 3u]);
    let d = vec3f(given[i + 4u], given[i + 5u], given[i + 6u]);
    let lobe = sh_cosine_lobe(d);
    let dominant = sh_dominant_lobe(c);
    let out = 10u * id.x;
    result[out] = sh_evaluate(c, d);
    for (var k = 0u; k < 4u; k++) { result[out + 1u + k] = lobe[k]; }
    result[out + 5u] = dominant.flux;
    result[out + 6u] = dominant.fraction;
    for (var k = 0u; k < 3u; k++) { result[out + 7u + k] = dominant.direction[k]; }
}
