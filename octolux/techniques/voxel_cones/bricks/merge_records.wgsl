// Records of nodes with new numbers (merge_directory.wgsl): of what moves those that are shown, whose bricks stand behind those
// of what is static (from parameters.first on), and of what is static the others.
{{ use("techniques/voxel_cones/octree/octree.wgsl") }}

{% for part in parts %}
fn {{ part }}record(node: u32, first: u32) -> Node {
    let packed = {{ part }}ways[node];
    var brick = packed >> 6u;
    var packed_scales = vec2u(0u);
    {% for way in range(6) %}
    if (packed & {{ 2 ** way }}u) != 0u {
        packed_scales.{{ "xy"[way % 2] }} |= {{ part }}scales[brick] << {{ 8 * (way // 2) }}u;
        brick += 1u;
    }
    {% endfor %}
    return Node(first + (packed >> 6u), packed & 63u, packed_scales.x, packed_scales.y);
}
{% endfor %}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let word = id.x + {{ row }}u * id.y;
    if word >= parameters.count || shown[word] == 0u { return; }
    let entry = textureLoad(merged_directory, vec2u(word & {{ directory_row - 1 }}u, word / {{ directory_row }}u), 0).xy;
    var mask = entry.x;
    var number = entry.y;
    while mask != 0u {
        let bit = firstTrailingBit(mask);
        let code = 32u * word + bit;
        if ((shown[word] >> bit) & 1u) == 1u {
            store_nodes(number, record(node_of(code), parameters.first));
        } else {
            store_nodes(number, static_record(static_node_of(code), 0u));
        }
        number += 1u;
        mask &= mask - 1u;
    }
}
