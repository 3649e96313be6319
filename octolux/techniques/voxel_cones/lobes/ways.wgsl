// A node has three bricks, in places of the first three ways: bits, and how many.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let node = id.x + {{ row }}u * id.y;
    if node >= parameters.count { return; }
    masks[node] = 7u;
    values[node] = 3u;
}
