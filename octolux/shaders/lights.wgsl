// Lights and their shadow maps. Lights lie in the order directional, spot, point; each light's first view is
// `light.view`, whose shadow map is layer `light.view - 1` (view 0 is the camera).
// With `shadows` it needs views, shadow_maps and shadow_sampler.

// Illuminance on a plane that faces the light (lux).
fn directional_illuminance(light: Light) -> vec3f { return light.color; }
fn point_illuminance(light: Light, to_light: vec3f) -> vec3f { return light.color / dot(to_light, to_light); }

// KHR_lights_punctual: a linear ramp in the cosine between the cones, squared. `l` points to the light.
fn spot_attenuation(light: Light, l: vec3f) -> f32 {
    let ramp = saturate((dot(-l, light.direction) - light.cos_outer) * light.cone_slope);
    return ramp * ramp;
}

{% if shadows %}
// Which of the six faces a direction from the light falls on: +x -x +y -y +z -z.
fn cube_face(d: vec3f) -> u32 {
    let a = abs(d);
    if a.x > a.y && a.x > a.z { return select(0u, 1u, d.x < 0.0); }
    if a.y > a.z { return select(2u, 3u, d.y < 0.0); }
    return select(4u, 5u, d.z < 0.0);
}

// Fraction of the light that reaches `position`, 2x2 percentage-closer filtering by the comparison sampler.
// `footprint` is the width of a shadow texel there. The filter reaches one texel to each side, sqrt(2) texels along
// its diagonal; on a plane whose normal is at angle t to the light the depth varies by footprint * sqrt(2) * tan(t) over
// it, and a move by d along the normal clears d / cos(t): d = sqrt(2) * footprint * sin(t) is just enough. A 64th of a
// texel covers the rounding of depths where the surface faces the light.
fn lit_fraction(view_index: u32, position: vec3f, normal: vec3f, l: vec3f, footprint: f32) -> f32 {
    let cosine = dot(normal, l);
    let sine = sqrt(saturate(1.0 - cosine * cosine));
    let receiver = position + normal * (1.41421356 * footprint * max(sine, 0.015625));
    let clip = views[view_index].view_projection * vec4f(receiver, 1.0);
    let ndc = clip.xyz / clip.w;
    let uv = ndc.xy * vec2f(0.5, -0.5) + 0.5;
    return textureSampleCompareLevel(shadow_maps, shadow_sampler, uv, view_index - 1u, ndc.z);
}
{% endif %}
