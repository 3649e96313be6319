// Of the surfels that several buffers have seen in a cell, the most counts (CLPV 3.2), up to a wall; the first of equals. The
// sums are zeroed for the next.
{% set numbers = 8 if planes else 3 %}
{% if planes %}

// Three sums with what has gone beyond 32 bits.
fn sum_of(at: u32, carries: u32) -> vec3f {
    let beyond = (vec3u(sums[carries]) >> vec3u(0u, 10u, 20u)) & vec3u(1023u);
    return vec3f(vec3u(sums[at], sums[at + 1u], sums[at + 2u])) + 4294967296.0 * vec3f(beyond);
}
{% endif %}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= {{ cells }}u { return; }
    var most = vec3f(0.0);
    {% if planes %}
    var within = vec3f(0.0); // mean of the buffer that has the most
    {% endif %}
    {% for buffer in range(at_once) %}
    {
        let at = {{ numbers }}u * (id.x + {{ buffer * cells }}u);
        {% if planes %}
        let sum = sum_of(at, at + 6u);
        {% else %}
        let sum = vec3f(vec3u(sums[at], sums[at + 1u], sums[at + 2u]));
        {% endif %}
        if any(sum > vec3f(0.0)) {
            let found = min(vec3f(1.0), sum / surfels.one);
            {% if planes %}
            within = select(within, sum_of(at + 3u, at + 7u) / max(sum, vec3f(1.0)), found > most);
            {% endif %}
            most = max(most, found);
            {% for k in range(numbers) %}
            sums[at + {{ k }}u] = 0u;
            {% endfor %}
        }
    }
    {% endfor %}
    if any(most > vec3f(0.0)) {
        {% if planes %}
        offsets[id.x] = vec4f(select(offsets[id.x].xyz, within, most > shares[id.x].xyz), 0.0);
        {% endif %}
        shares[id.x] = max(shares[id.x], vec4f(most, 0.0));
    }
}
