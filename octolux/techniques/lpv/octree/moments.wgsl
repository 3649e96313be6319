// First moments of the finest level: weight times place, and the weight, which is band 0 summed over the channels. The
// light of a cell is half a cell behind its middle, where its surfaces are (simulator/lpv/gathering.py, `light_nodes`);
// that of its parents at the centroid of theirs.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) cell: vec3u) {
    if any(cell >= vec3u({{ n }}u)) { return; }
    let number = cell.x + {{ n }}u * (cell.y + {{ n }}u * cell.z);
    let sum = injected[3u * number] + injected[3u * number + 1u] + injected[3u * number + 2u];
    let behind = {{ 0.25 * 3 ** 0.5 }} * sum.wyz;
    moments[number] = vec4f(sum.x * (vec3f(cell) + 0.5) - behind, sum.x);
}
