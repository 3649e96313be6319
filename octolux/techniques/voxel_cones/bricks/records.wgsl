// What shaders that read bricks want to know of a node: its bricks, and their scales.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    {% if listed %}
    let thread = id.x + {{ row }}u * id.y;
    if thread >= lists[{{ 4 * depth + 3 }}] { return; }
    let listed_brick = update_list[thread];
    let node = owners[listed_brick] >> 3u;
    let packed = ways[node];
    if packed >> 6u != listed_brick { return; } // a node's first brick does for all
    {% else %}
    let node = id.x + {{ row }}u * id.y;
    if node >= parameters.count { return; }
    let packed = ways[node];
    {% endif %}
    var brick = packed >> 6u;
    var packed_scales = vec2u(0u);
    {% for way in range(6) %}
    if (packed & {{ 2 ** way }}u) != 0u {
        packed_scales.{{ "xy"[way % 2] }} |= scales[brick] << {{ 8 * (way // 2) }}u;
        brick += 1u;
    }
    {% endfor %}
    store_nodes(node, Node(packed >> 6u, packed & 63u, packed_scales.x, packed_scales.y));
}
