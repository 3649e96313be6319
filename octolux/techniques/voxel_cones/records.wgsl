// What shaders that read bricks want to know of a node: its bricks, and their scales.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let node = id.x + {{ row }}u * id.y;
    if node >= parameters.count { return; }
    let packed = ways[node];
    var brick = packed >> 6u;
    var codes = vec2u(0u);
    {% for way in range(6) %}
    if (packed & {{ 2 ** way }}u) != 0u {
        codes.{{ "xy"[way % 2] }} |= scales[brick] << {{ 8 * (way // 2) }}u;
        brick += 1u;
    }
    {% endfor %}
    store_nodes(node, Node(packed >> 6u, packed & 63u, codes.x, codes.y));
}
