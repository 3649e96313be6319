// Of the surfels that several buffers have seen in a cell, the most counts (CLPV 3.2). The sums are zeroed for the next.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= {{ cells }}u { return; }
    let sum = vec3u(sums[3u * id.x], sums[3u * id.x + 1u], sums[3u * id.x + 2u]);
    if all(sum == vec3u(0u)) { return; }
    let share = min(vec3f(1.0), vec3f(sum) / {{ one }}.0);
    shares[id.x] = max(shares[id.x], vec4f(share, 0.0));
    for (var k = 0u; k < 3u; k++) { sums[3u * id.x + k] = 0u; }
}
