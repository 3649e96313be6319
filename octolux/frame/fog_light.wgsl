// Fluence that lamps, emitters and the sky bring to a point in the air, past the scene and through the medium. A point has no
// plane, so shadow maps are asked for one texel; jitter and the filter after it make up for its edges.
// Templates: groups, emitters, sky and where the views of the last two begin, as frame/direct.wgsl has them.

{% macro reaches(name, maps, first_view) %}
// Whether light of a view arrives: 0 or 1. What lies outside of an orthographic map has nothing before it.
fn {{ name }}(view_index: u32, position: vec3f) -> f32 {
    let view = views[view_index];
    let clip = view.view_projection * vec4f(position, 1.0);
    let ndc = clip.xyz / clip.w;
    let texel = clamp((ndc.xy * vec2f(0.5, -0.5) + 0.5) * view.size, vec2f(0.0), vec2f(view.size - 1.0));
    let nearest = textureLoad({{ maps }}, vec2u(texel), view_index - {{ first_view }}u, 0);
    let outside = view.perspective == 0u && any(abs(ndc.xy) > vec2f(1.0));
    return select(0.0, 1.0, outside || max(ndc.z, 0.0) >= nearest);
}
{% endmacro %}
{{ reaches("reaches", "shadow_maps", 1) }}
{% if coarse %}
{{ reaches("reaches_coarse", "coarse_maps", coarse_view) }}
{% endif %}

// Mean of 1 / (r^2 + more) along a step around `middle`, r being the distance to the light: the angle under which it sees
// the step, over the step and the distance of their line. At one point it would be without bound.
fn mean_falloff(to_light: vec3f, direction: vec3f, step: f32, more: f32) -> f32 {
    let along = dot(to_light, direction);
    let square = max(dot(to_light, to_light) - along * along, 1e-8 * step * step) + more;
    let height = sqrt(square);
    return atan2(height * step, square + along * along - 0.25 * step * step) / max(height * step, 1e-37);
}

fn lamp_falloff(light: Light, middle: vec3f, direction: vec3f, step: f32) -> f32 {
    {% if inverse_square %}
    return mean_falloff(light.position - middle, direction, step, 0.0);
    {% else %}
    return 1.0;
    {% endif %}
}

fn fluence_directional(light: Light, view: u32, position: vec3f, middle: vec3f, direction: vec3f, step: f32) -> vec3f {
    return light.color * through_from_afar(light, position) * reaches(view, position);
}
fn fluence_spot(light: Light, view: u32, position: vec3f, middle: vec3f, direction: vec3f, step: f32) -> vec3f {
    let cone = spot_attenuation(light, normalize(light.position - position));
    let falloff = lamp_falloff(light, middle, direction, step);
    return light.color * through_from_place(light, position) * (reaches(view, position) * cone * falloff);
}
fn fluence_point(light: Light, view: u32, position: vec3f, middle: vec3f, direction: vec3f, step: f32) -> vec3f {
    let lit = reaches(view + cube_face(position - light.position), position);
    let falloff = lamp_falloff(light, middle, direction, step);
    return light.color * through_from_place(light, position) * (lit * falloff);
}
{% if emitters %}
fn fluence_emitter(light: Light, view: u32, position: vec3f, middle: vec3f, direction: vec3f, step: f32) -> vec3f {
    let away = position - light.position;
    let lit = reaches_coarse(view + cube_face(away), position) * emitter_lobe(light, normalize(away));
    let falloff = mean_falloff(light.position - middle, direction, step, light.cone_slope);
    return light.color * through_from_place(light, position) * (lit * falloff);
}
{% endif %}

{% if sky %}
{% set parts = 32 if sky >= 32 else 16 %}
// Some of the sky's lights are asked for all. In a tile of 4 x 4 texels all are asked once at each step, or where they are
// many in two steps; along a path each texel comes by all of them.
fn sky_fluence(position: vec3f, order: u32, number: u32) -> vec3f {
    let part = (order + {{ 17 if parts == 32 else 5 }}u * number) & {{ parts - 1 }}u;
    var fluence = vec3f(0.0);
    {% for first in range(0, sky, parts) %}
    {
        {% if first + parts > sky %}
        let there = select(0.0, 1.0, part < {{ sky - first }}u);
        let index = min({{ first }}u + part, {{ sky - 1 }}u);
        {% else %}
        let there = 1.0;
        let index = {{ first }}u + part;
        {% endif %}
        let light = lights[{{ sky_first }}u + index];
        let lit = there * reaches_coarse({{ sky_view }}u + index, position);
        fluence += light.color * through_from_afar(light, position) * lit;
    }
    {% endfor %}
    return {{ parts }}.0 * fluence;
}
{% endif %}

// order: the texel's place in the dither. number: of the step.
fn lamp_fluence(position: vec3f, middle: vec3f, direction: vec3f, step: f32, order: u32, number: u32) -> vec3f {
    var fluence = vec3f(0.0);
    {% for kind, first, count, first_view, views_each in groups %}
    {% if unrolled %}
    {% for i in range(count) %}
    fluence += fluence_{{ kind }}(lights[{{ first + i }}], {{ first_view + i * views_each }}u, position, middle, direction, step);
    {% endfor %}
    {% elif count %}
    for (var i = 0u; i < {{ count }}u; i++) {
        fluence += fluence_{{ kind }}(lights[{{ first }}u + i], {{ first_view }}u + i * {{ views_each }}u, position, middle, direction, step);
    }
    {% endif %}
    {% endfor %}
    {% if sky %}
    fluence += sky_fluence(position, order, number);
    {% endif %}
    return fluence;
}
