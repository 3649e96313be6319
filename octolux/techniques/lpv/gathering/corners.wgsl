// Of the eight cells around a place, whose middles are its corners, how much each counts (simulator/lpv/corners.py, `corner_weights`):
// by the place between them, and by what planes let through on the way from the place to the middle.
{% if occlusion %}{{ use("techniques/lpv/gathering/planes.wgsl") }}{% endif %}

// first: the lowest cell; low: the weights of its layer, x before y; high: of the next along z.
struct Corners { first: vec3i, low: vec4f, high: vec4f }

fn corner_cell(first: vec3i, corner: u32) -> vec3u {
    return vec3u(clamp(first + vec3i(vec3u(corner & 1u, (corner >> 1u) & 1u, corner >> 2u)), vec3i(0), vec3i({{ n - 1 }})));
}

// place: in cells of the window from its corner.
fn corners_at(window: u32, place: vec3f) -> Corners {
    let first = vec3i(floor(place - 0.5));
    let part = place - 0.5 - vec3f(first);
    {% for corner in range(8) %}
    {% set at = (corner % 2, corner // 2 % 2, corner // 4) %}
    let between_{{ corner }} = {% for axis in "xyz" %}{{ "part" if at[loop.index0] else "(1.0 - part" }}.{{ axis }}{{ "" if at[loop.index0] else ")" }}{{ "" if loop.last else " * " }}{% endfor %};
    {% endfor %}
    let low = vec4f(between_0, between_1, between_2, between_3);
    let high = vec4f(between_4, between_5, between_6, between_7);
    {% if occlusion %}
    {% for corner in range(8) %}
    let cell_{{ corner }} = corner_cell(first, {{ corner }}u);
    let words_{{ corner }} = geometry[{{ n**3 }}u * window + cell_{{ corner }}.x + {{ n }}u * (cell_{{ corner }}.y + {{ n }}u * cell_{{ corner }}.z)];
    // From 0 to 2 along each axis, from the lowest cell on: where the planes are, past which nothing goes.
    let shares_{{ corner }} = shares_of(words_{{ corner }});
    let planes_{{ corner }} = planes_of(words_{{ corner }}) + vec3f({{ corner % 2 }}.0, {{ corner // 2 % 2 }}.0, {{ corner // 4 }}.0);
    {% endfor %}
    {% for corner in range(8) %}
    {% set at = (corner % 2, corner // 2 % 2, corner // 4) %}
    let passed_{{ corner }} = {% for axis in "xyz" %}{% set other = corner + (1, 2, 4)[loop.index0] * (1 - 2 * at[loop.index0]) -%}
        (1.0 - max(blocked(part.{{ axis }} + 0.5, {{ at[loop.index0] + 0.5 }}, planes_{{ corner }}.{{ axis }}, shares_{{ corner }}.{{ axis }}),
            blocked(part.{{ axis }} + 0.5, {{ at[loop.index0] + 0.5 }}, planes_{{ other }}.{{ axis }}, shares_{{ other }}.{{ axis }}))){{ "" if loop.last else " * " }}{% endfor %};
    {% endfor %}
    let low_seen = low * vec4f(passed_0, passed_1, passed_2, passed_3);
    let high_seen = high * vec4f(passed_4, passed_5, passed_6, passed_7);
    let all = dot(low_seen, vec4f(1.0)) + dot(high_seen, vec4f(1.0));
    // Where planes lie on all sides, the nearest cells are all there is.
    if all > {{ closed }} { return Corners(first, low_seen / all, high_seen / all); }
    {% endif %}
    return Corners(first, low, high);
}

{% if occlusion %}
// Of a plane between place and middle its share; of one that lies nearer to the place than planes are known, on whichever side, part.
fn blocked(place: f32, middle: f32, plane: f32, share: f32) -> f32 {
    let upwards = middle > place;
    let ahead = select(place - plane, plane - place, upwards);
    let before = select(plane > middle, plane < middle, upwards);
    return select(0.0, share * saturate(0.5 + {{ 0.5 / unsure }} * ahead), before);
}
{% endif %}
