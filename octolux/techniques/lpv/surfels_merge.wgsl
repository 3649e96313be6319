// Of the surfels that several buffers have seen in a cell, the most counts (CLPV 3.2). The sums are zeroed for the next.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= {{ cells }}u { return; }
    var most = vec3u(0u);
    {% for buffer in range(at_once) %}
    {
        let at = 3u * (id.x + {{ buffer * cells }}u);
        let sum = vec3u(sums[at], sums[at + 1u], sums[at + 2u]);
        most = max(most, sum);
        if any(sum != vec3u(0u)) {
            sums[at] = 0u;
            sums[at + 1u] = 0u;
            sums[at + 2u] = 0u;
        }
    }
    {% endfor %}
    if any(most != vec3u(0u)) {
        shares[id.x] = max(shares[id.x], vec4f(min(vec3f(1.0), vec3f(most) / {{ one }}.0), 0.0));
    }
}
