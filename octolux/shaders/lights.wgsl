// Lights and their shadow maps. Lights lie in the order directional, spot, point, emitter, sky, and so do their views: one
// each, six for a point or emitter. View 0 is the camera; the shadow map of view i is layer i - 1; those of emitters and sky
// are an array of their own. With `shadows` it needs views, shadow_maps and shadow_sampler; with `coarse` also coarse_maps.

// Illuminance on a plane that faces the light (lux).
fn directional_illuminance(light: Light) -> vec3f { return light.color; }
// Of a point or spot light; without the inverse square what it brings at 1 m, at any distance.
{% if inverse_square %}
fn point_illuminance(light: Light, to_light: vec3f) -> vec3f { return light.color / dot(to_light, to_light); }
{% else %}
fn point_illuminance(light: Light, to_light: vec3f) -> vec3f { return light.color; }
{% endif %}

// What of an emitter's intensity goes to unit direction w (frame/emitters.py); cos_outer holds its beam.
fn emitter_lobe(light: Light, w: vec3f) -> f32 {
    return 4.0 * light.cos_outer * max(dot(w, light.direction), 0.0) + 1.0 - light.cos_outer;
}
// cone_slope holds the squared radius of a disk of its area.
fn emitter_illuminance(light: Light, to_light: vec3f) -> vec3f {
    let square = dot(to_light, to_light);
    return light.color * (emitter_lobe(light, -to_light * inverseSqrt(square)) / (square + light.cone_slope));
}

// KHR_lights_punctual: a linear ramp in the cosine between the cones, squared. `l` points to the light.
fn spot_attenuation(light: Light, l: vec3f) -> f32 {
    let ramp = saturate((dot(-l, light.direction) - light.cos_outer) * light.cone_slope);
    return ramp * ramp;
}

// Which of the six faces a direction from the light falls on: +x -x +y -y +z -z.
fn cube_face(d: vec3f) -> u32 {
    let a = abs(d);
    if a.x > a.y && a.x > a.z { return select(0u, 1u, d.x < 0.0); }
    if a.y > a.z { return select(2u, 3u, d.y < 0.0); }
    return select(4u, 5u, d.z < 0.0);
}

{% if shadows %}
// Fraction of the light that reaches `position`: 2x2 percentage-closer filtering, or where shadow_filter is 1 what the nearest
// of the four texels says. Each of the four is compared with
// the depth that the receiver's own plane has at that texel's centre, so that the plane never shadows itself, however it
// is slanted; depth is affine across the map for a perspective (near / depth) as well as an orthographic view. Where the
// plane falls away from the light the receiver's own depth is kept: the plane may end there, as at the foot of a wall.
// What is left for a normal-offset bias is the rasteriser's snapping of vertices to 1/256 texel, which tilts a plane by up
// to sin(t) / 256 of a texel's width along the normal, and rounding. An eighth of a texel is ample; from 1/64 to 1/4 the
// mean direct light of the Dabrovic Sponza changes by less than 1 %.
{% macro lit_fraction(name, maps, first_view) %}
fn {{ name }}(view_index: u32, position: vec3f, normal: vec3f, footprint: f32) -> f32 {
    let view = views[view_index];
    let receiver = position + normal * (0.125 * footprint);
    let clip = view.view_projection * vec4f(receiver, 1.0);
    let ndc = clip.xyz / clip.w;
    let texel = (ndc.xy * vec2f(0.5, -0.5) + 0.5) * view.size - 0.5;
    // Change of depth from texel to texel along the plane; held where the plane is seen edge-on and hardly lit.
    var slope: vec2f;
    if view.perspective == 1u {
        let from_light = receiver - view.origin;
        let away = max(-dot(normal, from_light), 1e-3 * length(from_light));
        slope = -vec2f(dot(normal, view.direction_dx), dot(normal, view.direction_dy)) / away;
    } else {
        let away = max(-dot(normal, view.direction), 1e-3);
        slope = -vec2f(dot(normal, view.origin_dx), dot(normal, view.origin_dy)) / away;
    }
    // At a map's rim the nearest texels it has, with the plane's depth there: a cube's faces meet without a seam.
    let low = clamp(floor(texel), vec2f(0.0), vec2f(view.size - 2.0));
    let weight = {{ "round" if shadow_filter == 1 else "" }}(saturate(texel - low));
    let nearest = textureGather({{ maps }}, shadow_sampler, (low + 1.0) / view.size, view_index - {{ first_view }}u);
    let left_right = (low.x - texel.x + vec2f(0.0, 1.0)) * (slope.x * view.depth_scale);
    let up_down = (low.y - texel.y + vec2f(0.0, 1.0)) * (slope.y * view.depth_scale);
    // A gather's order: lower left, lower right, upper right, upper left. Reverse z: larger is nearer.
    let plane = ndc.z + left_right.xyyx + up_down.yyxx;
    let lit = select(vec4f(0.0), vec4f(1.0), max(plane, vec4f(ndc.z)) >= nearest);
    return mix(mix(lit.w, lit.z, weight.x), mix(lit.x, lit.y, weight.x), weight.y);
}
{% endmacro %}
{{ lit_fraction("lit_fraction", "shadow_maps", 1) }}
{% if coarse %}
{{ lit_fraction("coarse_fraction", "coarse_maps", coarse_view) }}
{% endif %}
{% endif %}
