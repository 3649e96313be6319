// The G-buffer's 128 bits: shading normal 32 | geometric normal 24, specular 8 | base color r, g 16 each |
// base color b 16, roughness 8, metallic 8. Sixteen bits a channel keep dark albedos within 1e-3 of themselves.
{{ use("shaders/octahedral.wgsl") }}

struct Surface {
    normal: vec3f,
    geometric_normal: vec3f,
    base_color: vec3f,
    roughness: f32,
    metallic: f32,
    specular: f32,
}

fn pack_surface(s: Surface) -> vec4u {
    let geometric = vec2u(round((octahedral_encode(s.geometric_normal) * 0.5 + 0.5) * 4095.0));
    let bytes = vec3u(round(saturate(vec3f(s.specular, s.roughness, s.metallic)) * 255.0));
    let blue = pack2x16unorm(vec2f(s.base_color.b, 0.0));
    return vec4u(
        pack_unit_vector(s.normal),
        geometric.x | geometric.y << 12u | bytes.x << 24u,
        pack2x16unorm(s.base_color.rg),
        blue | bytes.y << 16u | bytes.z << 24u,
    );
}

fn unpack_surface(p: vec4u) -> Surface {
    let geometric = vec2f(vec2u(p.y & 4095u, (p.y >> 12u) & 4095u)) / 4095.0 * 2.0 - 1.0;
    let bytes = vec3f(vec3u(p.y >> 24u, (p.w >> 16u) & 255u, p.w >> 24u)) / 255.0;
    return Surface(
        unpack_unit_vector(p.x),
        octahedral_decode(geometric),
        vec3f(unpack2x16unorm(p.z), unpack2x16unorm(p.w).x),
        bytes.y, bytes.z, bytes.x,
    );
}
