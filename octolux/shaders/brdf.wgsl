// The metallic-roughness BRDF of glTF 2.0, appendix B; the reference and its sources are simulator/brdf.py.
{{ use("shaders/gbuffer.wgsl") }}

fn diffuse_albedo(s: Surface) -> vec3f { return s.base_color * (1.0 - s.metallic); }

// Schlick's Fresnel for the cosine of view and half vector.
fn fresnel(s: Surface, v_h: f32) -> vec3f {
    let away = 1.0 - saturate(v_h);
    let grazing = away * away * away * away * away;
    let weight = s.specular * (1.0 - s.metallic);
    let f0 = mix(vec3f({{ dielectric_f0 }} * s.specular), s.base_color, s.metallic);
    return f0 + (weight + s.metallic - f0) * grazing;
}

// Of the diffuse and the specular lobe.
struct TwoLobes { diffuse: vec3f, specular: vec3f }

fn plus(a: TwoLobes, b: TwoLobes) -> TwoLobes { return TwoLobes(a.diffuse + b.diffuse, a.specular + b.specular); }
fn times(a: TwoLobes, by: vec3f) -> TwoLobes { return TwoLobes(a.diffuse * by, a.specular * by); }

// f(l, v), 1/sr; all vectors unit length. A shading normal may lean away from the eye, which then counts as on the horizon.
fn brdf_lobes(s: Surface, l: vec3f, v: vec3f) -> TwoLobes {
    let roughness = max(s.roughness, {{ min_roughness }});
    let alpha = roughness * roughness;
    let square = alpha * alpha;
    let h = normalize(l + v);
    let n_l = max(dot(s.normal, l), 0.0);
    let n_v = max(dot(s.normal, v), 0.0);
    let n_h = max(dot(s.normal, h), 0.0);
    let reflected = fresnel(s, dot(v, h));
    let spread = n_h * n_h * (square - 1.0) + 1.0;
    let distribution = square / ({{ pi }} * spread * spread);
    let smith = n_l * sqrt(square + (1.0 - square) * n_v * n_v) + n_v * sqrt(square + (1.0 - square) * n_l * n_l);
    let visibility = select(0.5 / smith, 0.0, smith <= 0.0);
    return TwoLobes((1.0 - reflected) * diffuse_albedo(s) / {{ pi }}, reflected * distribution * visibility);
}

fn brdf(s: Surface, l: vec3f, v: vec3f) -> vec3f {
    let lobes = brdf_lobes(s, l, v);
    return lobes.diffuse + lobes.specular;
}
