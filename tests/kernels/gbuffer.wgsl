// Test kernel: a surface packed into 128 bits.
{{ use("shaders/gbuffer.wgsl") }}

fn triple(first: u32) -> vec3f { return vec3f(given[first], given[first + 1u], given[first + 2u]); }

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= {{ threads }}u { return; }
    let i = 12u * id.x;
    let s = unpack_surface(pack_surface(
        Surface(triple(i), triple(i + 3u), triple(i + 6u), given[i + 9u], given[i + 10u], given[i + 11u])));
    for (var k = 0u; k < 3u; k++) {
        result[i + k] = s.normal[k];
        result[i + 3u + k] = s.geometric_normal[k];
        result[i + 6u + k] = s.base_color[k];
    }
    result[i + 9u] = s.roughness;
    result[i + 10u] = s.metallic;
    result[i + 11u] = s.specular;
}
