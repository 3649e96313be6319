// Of the shares that several buffers have seen in a cell, the most count (CLPV 3.2).{% if last %} The albedo is the mean of all.{% endif %}

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
    let red_green = tints[2u * cell];
    let blue_area = tints[2u * cell + 1u];
    let tint = vec4f(vec4u(red_green.xz, blue_area.xz)) + 4294967296.0 * vec4f(vec4u(red_green.yw, blue_area.yw));
    let albedo = tint.rgb / max(tint.a, 1.0);
    reflectors[3u * cell + 2u] = vec4f(albedo, dot(albedo, vec3f({{ luminance }})));
    {% endif %}
}
