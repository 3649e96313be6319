// The update list (VCT 5.5): bricks that hold a voxel of a node whose light was made anew. They come in any order: no
// result depends on it.
{{ use("techniques/voxel_cones/octree.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let node = id.x + {{ row }}u * id.y;
    if node >= parameters.count { return; }
    let around = around_node(codes[node]);
    var any = 0u;
    {% for o in range(8) %}
    any |= select(touched[min(around[{{ o }}], parameters.third)], 0u, around[{{ o }}] == NO_NODE);
    {% endfor %}
    if any == 0u { return; }
    let count = countOneBits(ways[node] & 63u);
    let first = atomicAdd(&update_count[0], count);
    for (var k = 0u; k < count; k++) { update_list[first + k] = (ways[node] >> 6u) + k; }
}
