// Sums of what the sides of an octree's coarse voxels receive (receive.wgsl): {{ parts }}, each of every {{ parts }}th side. Whole
// numbers have the same sum in any order, and wherever what moves has the nodes of what is static: 2^-22 of a unit, of which
// 16 bits are kept, and what is above.
{{ use("techniques/voxel_cones/bricks/bright.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= {{ parts }}u { return; }
    var low = vec3u(0u);
    var high = vec3u(0u);
    for (var side = id.x; side < summed.sides; side += {{ parts }}u) {
        {% if beside %}
        let code = codes[owners[summed.first_brick + side / {{ sides }}u] >> 3u];
        if ((shown[code >> 5u] >> (code & 31u)) & 1u) != summed.moves { continue; }
        {% endif %}
        let whole = vec3u({{ 2.0 ** 22 }} * unpack_bright(received[summed.begin + side]));
        low += whole & vec3u(65535u);
        high += whole >> vec3u(16u);
    }
    let place = 2u * (summed.first_sum + id.x);
    sums[place] = vec4u(low & vec3u(65535u), 0u);
    sums[place + 1u] = vec4u(high + (low >> vec3u(16u)), 0u);
}
