// The next direction of a path: from the diffuse lobe or from the visible normals of the specular one.

struct Bounce { direction: vec3f, density: f32, weight: vec3f }

fn alpha_of(s: Surface) -> f32 {
    let roughness = max(s.roughness, {{ min_roughness }});
    return roughness * roughness;
}

// How often the specular lobe is asked: by its share of what both lobes reflect of even light.
fn specular_share(s: Surface, n_v: f32) -> f32 {
    let even = even_reflection(max(s.roughness, {{ min_roughness }}), n_v);
    let f0 = mix(vec3f({{ dielectric_f0 }} * s.specular), s.base_color, s.metallic);
    let f90 = s.specular * (1.0 - s.metallic) + s.metallic;
    let specular = dot(f0 * even.x + f90 * even.y, {{ luminance }});
    let diffuse = dot(diffuse_albedo(s), {{ luminance }});
    let total = specular + diffuse;
    return select(0.0, specular / total, total > 0.0 && n_v > 0.0);
}

// Density with which sample_bounce takes unit direction l.
fn bounce_density_of(s: Surface, to_eye: vec3f, l: vec3f) -> f32 {
    let n_l = dot(s.normal, l);
    let n_v = dot(s.normal, to_eye);
    let share = specular_share(s, n_v);
    var density = (1.0 - share) * max(n_l, 0.0) / {{ pi }};
    if share > 0.0 {
        let h = normalize(l + to_eye);
        density += share * visible_density(dot(s.normal, h), n_v, alpha_of(s));
    }
    return density;
}

// Radiance that leaves towards the eye for each unit of radiance from l; 0 where a side is hidden, as in frame/direct.wgsl.
fn reflection(s: Surface, to_eye: vec3f, l: vec3f) -> vec3f {
    let above = dot(s.geometric_normal, l) > 0.0;
    return select(vec3f(0.0), brdf(s, l, to_eye) * max(dot(s.normal, l), 0.0), above);
}

fn sample_bounce(s: Surface, to_eye: vec3f, choice: f32, u: vec2f) -> Bounce {
    let basis = basis_of(s.normal);
    let n_v = dot(s.normal, to_eye);
    var l: vec3f;
    if choice < specular_share(s, n_v) {
        let h = from_basis(basis, sample_visible_half(into_basis(basis, to_eye), alpha_of(s), u));
        l = reflect(-to_eye, h);
    } else {
        l = from_basis(basis, sample_cosine(u));
    }
    let density = bounce_density_of(s, to_eye, l);
    if density <= 0.0 { return Bounce(l, 0.0, vec3f(0.0)); }
    return Bounce(l, density, reflection(s, to_eye, l) / density);
}
