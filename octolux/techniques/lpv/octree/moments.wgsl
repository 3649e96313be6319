// First moments of the finest level: weight times place, and the weight, which is band 0 summed over the channels. The
// light of a cell is taken to be in its middle; its parents' is at the centroid of theirs.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) cell: vec3u) {
    if any(cell >= vec3u({{ n }}u)) { return; }
    let number = cell.x + {{ n }}u * (cell.y + {{ n }}u * cell.z);
    let weight = injected[3u * number].x + injected[3u * number + 1u].x + injected[3u * number + 2u].x;
    moments[number] = vec4f(weight * (vec3f(cell) + 0.5), weight);
}
