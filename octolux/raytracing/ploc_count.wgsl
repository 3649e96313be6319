// PLOC, step 2: which clusters stay (x) and which become a node with their partner (y). The first of a pair stays.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    if i >= parameters.count { return; }
    let other = nearest[i];
    let mutual = other != i && nearest[other] == i;
    values[i] = vec2u(select(1u, 0u, mutual && other < i), select(0u, 1u, mutual && i < other));
}
