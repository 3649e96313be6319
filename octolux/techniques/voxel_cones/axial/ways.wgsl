// Which of the six ways something faces in a node's brick: bits, and how many. A node has a brick for each of these.
{% if borrows %}
// A node at the border of what moves has what is static, whose voxels around it may have no nodes here.
{% endif %}
{{ use("techniques/voxel_cones/octree/octree.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let node = id.x + {{ row }}u * id.y;
    if node >= parameters.count { return; }
    let around = around_node(codes[node]);
    var up = 0u;
    var down = 0u;
    {% for o in range(8) %}
    if around[{{ o }}] != NO_NODE {
        {% for corner in borrowed[o] %}
        {
            let packed = facing[8u * around[{{ o }}] + {{ corner }}u];
            up |= packed.x;
            down |= packed.y;
        }
        {% endfor %}
    }
    {% endfor %}
    var mask = 0u;
    {% for axis in range(3) %}
    mask |= select(0u, {{ 1 * 4 ** axis }}u, (up & {{ 1023 * 1024 ** axis }}u) != 0u);
    mask |= select(0u, {{ 2 * 4 ** axis }}u, (down & {{ 1023 * 1024 ** axis }}u) != 0u);
    {% endfor %}
    {% if borrows %}
    let other = static_node_of(codes[node]);
    mask |= select(0u, static_ways[select(other, 0u, other == NO_NODE)] & 63u, other != NO_NODE);
    {% endif %}
    masks[node] = mask;
    values[node] = countOneBits(mask);
}
