// What a frame's surfels reflect, `newer`, joined with what was kept of those before, `older` (simulator/lpv/keeping.py): of
// shares the most, albedo {% if places %}and place {% endif %}of who has seen more.

fn sum_of(a: vec4f, b: vec4f) -> f32 { return dot(a + b, vec4f(1.0)); }

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let cell = id.x;
    if cell >= {{ cells }}u { return; }
    let more = sum_of(newer[3u * cell], newer[3u * cell + 1u]) > sum_of(older[3u * cell], older[3u * cell + 1u]);
    {% for k in range(2) %}
    {{ target }}[3u * cell + {{ k }}u] = max(newer[3u * cell + {{ k }}u], older[3u * cell + {{ k }}u]);
    {% endfor %}
    {{ target }}[3u * cell + 2u] = select(older[3u * cell + 2u], newer[3u * cell + 2u], more);
    {% if places %}
    {{ target }}_places[cell] = select(older_places[cell], newer_places[cell], more);
    {% endif %}
}
