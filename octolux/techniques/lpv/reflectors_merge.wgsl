// Of the shares that several buffers have seen in a cell, the most count (CLPV 3.2).{% if last %} The albedo is the mean of all.{% endif %}

{% if last %}
fn tint_sum(at: u32) -> f32 { return f32(tints[at].x) + 4294967296.0 * f32(tints[at].y); }
{% endif %}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let cell = id.x;
    if cell >= {{ cells }}u { return; }
    var most = vec4u(0u);
    var most_z = vec2u(0u);
    {% for buffer in range(buffers) %}
    {
        let at = 3u * (cell + {{ buffer * cells }}u);
        let z = sums[at + 2u];
        most = max(most, vec4u(sums[at], sums[at + 1u]));
        most_z = max(most_z, z);
    }
    {% endfor %}
    var x_and_y = min(vec4f(1.0), vec4f(most) / {{ one }}.0);
    var z = vec4f(min(vec2f(1.0), vec2f(most_z) / {{ one }}.0), 0.0, 0.0);
    {% if not first %}
    x_and_y = max(x_and_y, reflectors[3u * cell]);
    z = max(z, reflectors[3u * cell + 1u]);
    {% endif %}
    reflectors[3u * cell] = x_and_y;
    reflectors[3u * cell + 1u] = z;
    {% if last %}
    {% set words = 7 if places else 4 %}
    let tint = vec4f({% for k in range(4) %}tint_sum({{ words }}u * cell + {{ k }}u){{ "" if loop.last else ", " }}{% endfor %});
    let albedo = tint.rgb / max(tint.a, 1.0);
    reflectors[3u * cell + 2u] = vec4f(albedo, dot(albedo, vec3f({{ luminance }})));
    {% if places %}
    let place = vec3f({% for k in range(4, 7) %}tint_sum(7u * cell + {{ k }}u){{ "" if loop.last else ", " }}{% endfor %});
    places[cell] = vec4f(select(vec3f(0.0), 2.0 * place / tint.a - 1.0, tint.a > 0.0), 0.0);
    {% endif %}
    {% endif %}
}
