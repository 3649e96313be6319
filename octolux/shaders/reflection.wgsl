// What a surface makes of light out of its lobe: simulator/reflection.py, `reflected_direction`, and simulator/environment.py,
// `brdf_table`.
{{ use("shaders/brdf.wgsl") }}
{{ use("shaders/even_reflection.wgsl") }}

fn alpha_of(s: Surface) -> f32 {
    let roughness = max(s.roughness, {{ min_roughness }});
    return roughness * roughness;
}

fn reflected_direction(s: Surface, to_eye: vec3f) -> vec3f {
    let alpha = alpha_of(s);
    let direction = mix(s.normal, reflect(-to_eye, s.normal), (1.0 - alpha) * (sqrt(1.0 - alpha) + alpha));
    return normalize(direction - 2.0 * min(0.0, dot(direction, s.geometric_normal)) * s.geometric_normal);
}

// The specular lobe's directional albedo.
fn lobe_albedo(s: Surface, to_eye: vec3f) -> vec3f {
    let even = even_reflection(max(s.roughness, {{ min_roughness }}), max(dot(s.normal, to_eye), 0.0));
    let f0 = mix(vec3f({{ dielectric_f0 }} * s.specular), s.base_color, s.metallic);
    return f0 * even.x + (s.specular * (1.0 - s.metallic) + s.metallic) * even.y;
}
