// Where the volumes are sampled for a place in a window's cells: windows lie behind one another in y, and must not be
// filtered with each other.
fn texel_at(window: u32, place: vec3f) -> vec3f {
    {% if windows > 1 %}
    let held = clamp(place, vec3f(0.5), vec3f({{ n - 0.5 }})) + vec3f(0.0, {{ n }}.0 * f32(window), 0.0);
    {% else %}
    let held = place;
    {% endif %}
    return held * vec3f({{ 1 / n }}, {{ 1 / (n * windows) }}, {{ 1 / n }});
}
