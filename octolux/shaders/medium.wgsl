// The medium in its box, and what passes through it (reference: simulator/fog.py). It needs `medium`; with `density` also
// density_map, which holds shares of the peak, and density_sampler: hardware filters it, and repeats the edge.

// Where along a ray, in lengths of its direction, the box begins and ends; the ray misses it where the second is not larger.
fn medium_span(origin: vec3f, direction: vec3f) -> vec2f {
    let inverse = 1.0 / select(direction, vec3f(1e-20), abs(direction) < vec3f(1e-20));
    let a = (medium.low - origin) * inverse;
    let b = (medium.high - origin) * inverse;
    let first = min(a, b);
    let last = max(a, b);
    return vec2f(max(first.x, max(first.y, first.z)), min(last.x, min(last.y, last.z)));
}

{% if density %}
fn density_at(position: vec3f) -> f32 {
    return textureSampleLevel(density_map, density_sampler, (position - medium.low) / (medium.high - medium.low), 0.0).x;
}
{% endif %}

// Density times length, metres, from a point along a unit direction as far as `distance`.
fn medium_depth(position: vec3f, direction: vec3f, distance: f32) -> f32 {
    let span = medium_span(position, direction);
    let start = max(span.x, 0.0);
    let length = max(min(span.y, distance) - start, 0.0);
    {% if density %}
    var sum = 0.0;
    for (var i = 0u; i < {{ light_steps }}u; i++) {
        sum += density_at(position + direction * (start + (f32(i) + 0.5) * {{ 1 / light_steps }} * length));
    }
    return sum * {{ 1 / light_steps }} * length;
    {% else %}
    return length;
    {% endif %}
}

// What arrives at `position` of a light that is far away, and of one at a place.
fn through_from_afar(light: Light, position: vec3f) -> vec3f {
    return exp(-medium.extinction * medium_depth(position, -light.direction, 3e38));
}
fn through_from_place(light: Light, position: vec3f) -> vec3f {
    let to_light = light.position - position;
    let distance = max(length(to_light), 1e-20);
    return exp(-medium.extinction * medium_depth(position, to_light / distance, distance));
}
