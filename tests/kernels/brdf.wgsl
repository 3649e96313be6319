// Test kernel: given normal, light, eye, base color, roughness, metallic, specular; the BRDF.
{{ use("shaders/brdf.wgsl") }}

fn triple(first: u32) -> vec3f { return vec3f(given[first], given[first + 1u], given[first + 2u]); }

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= {{ threads }}u { return; }
    let i = 15u * id.x;
    let n = triple(i);
    let s = Surface(n, n, triple(i + 9u), given[i + 12u], given[i + 13u], given[i + 14u]);
    let f = brdf(s, triple(i + 3u), triple(i + 6u));
    for (var k = 0u; k < 3u; k++) { result[3u * id.x + k] = f[k]; }
}
