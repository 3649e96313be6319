// Of the surfels that several buffers have seen in a cell, the most counts (CLPV 3.2), up to a wall; the first of equals. The
// sums are zeroed for the next.
{% set numbers = 12 if planes else 3 %}
{% if planes %}

// Three sums with what has gone beyond 32 bits.
fn sum_of(low: vec3u, carries: u32) -> vec3f {
    let beyond = (vec3u(carries) >> vec3u(0u, 10u, 20u)) & vec3u(1023u);
    return vec3f(low) + 4294967296.0 * vec3f(beyond);
}

{# The sums of some names, three of each and then what has gone beyond of each, from a place in a buffer on. #}
{% macro sums_of(words, at, names) %}
{% for name in names %}
        let {{ name }}_sum = sum_of(vec3u({% for k in range(3) %}{{ words }}[{{ at }} + {{ 3 * names.index(name) + k }}u]{{ "" if loop.last else ", " }}{% endfor %}), {{ words }}[{{ at }} + {{ 3 * names|length + loop.index0 }}u]);
{% endfor %}
{% endmacro %}
{% endif %}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= {{ cells }}u { return; }
    {% for name in (("front", "back", "offset", "next", "last") if planes else ("most",)) %}
    var {{ name }} = vec3f(0.0);
    {% endfor %}
    {% for buffer in range(at_once) %}
    {
        let at = {{ numbers }}u * (id.x + {{ buffer * cells }}u);
        {% if planes %}
        {{ sums_of("sums", "at", ("fronts", "backs", "moments")) }}
        let sum = fronts_sum + backs_sum;
        {% else %}
        let sum = vec3f(vec3u(sums[at], sums[at + 1u], sums[at + 2u]));
        {% endif %}
        if any(sum > vec3f(0.0)) {
            {% if planes %}
            let fronts_found = min(vec3f(1.0), fronts_sum / surfels.one);
            let backs_found = min(vec3f(1.0), backs_sum / surfels.one);
            let more = max(fronts_found, backs_found) > max(front, back);
            // Places are the means of the buffer with the most.
            let beside = 8u * (id.x + {{ buffer * cells }}u);
            {{ sums_of("sums_beside", "beside", ("nexts", "lasts")) }}
            {% for k in range(8) %}
            sums_beside[beside + {{ k }}u] = 0u;
            {% endfor %}
            {% for place, sum in (("offset", "moments"), ("next", "nexts"), ("last", "lasts")) %}
            {{ place }} = select({{ place }}, {{ sum }}_sum / max(sum, vec3f(1.0)), more);
            {% endfor %}
            front = max(front, fronts_found);
            back = max(back, backs_found);
            {% else %}
            most = max(most, min(vec3f(1.0), sum / surfels.one));
            {% endif %}
            {% for k in range(numbers) %}
            sums[at + {{ k }}u] = 0u;
            {% endfor %}
        }
    }
    {% endfor %}
    {% if planes %}
    let most = max(front, back);
    {% endif %}
    if any(most > vec3f(0.0)) {
        {% if planes %}
        let more = most > max(fronts[id.x].xyz, backs[id.x].xyz);
        {% for place in ("offset", "next", "last") %}
        {{ place }}s[id.x] = vec4f(select({{ place }}s[id.x].xyz, {{ place }}, more), 0.0);
        {% endfor %}
        fronts[id.x] = max(fronts[id.x], vec4f(front, 0.0));
        backs[id.x] = max(backs[id.x], vec4f(back, 0.0));
        {% else %}
        shares[id.x] = max(shares[id.x], vec4f(most, 0.0));
        {% endif %}
    }
}
