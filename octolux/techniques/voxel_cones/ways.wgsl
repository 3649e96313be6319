// Which of the six ways something faces in a node's brick: bits, and how many. A node has a brick for each of these. Less
// than 2/1023 of a section is half a step of a brick's texels: nothing.
{{ use("techniques/voxel_cones/octree.wgsl") }}

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
    mask |= select(0u, {{ 1 * 4 ** axis }}u, (up & {{ 1022 * 1024 ** axis }}u) != 0u);
    mask |= select(0u, {{ 2 * 4 ** axis }}u, (down & {{ 1022 * 1024 ** axis }}u) != 0u);
    {% endfor %}
    masks[node] = mask;
    values[node] = countOneBits(mask);
}
