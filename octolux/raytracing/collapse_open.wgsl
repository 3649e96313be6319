// From the binary tree to nodes of four children, level by level. Step 1: which four nodes of the binary tree are a wide
// node's children. The child of the largest area is opened until there are four, those that are too large for a leaf
// first. Inner children come first.
{{ use("raytracing/binary_tree.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= parameters.count { return; }
    let number = parameters.first + id.x;
    var slots: array<u32, 4>;
    slots[0] = links[number].x;
    var used = 1u;
    while used < 4u {
        var widest = NOTHING;
        var widest_area = -1.0;
        var widest_large = false;
        for (var k = 0u; k < used; k++) {
            let count = node_size(slots[k]);
            let large = count > LEAF_SIZE;
            let area = node_area(slots[k]);
            if count > 1u && (widest == NOTHING || (large && !widest_large) || (large == widest_large && area > widest_area)) {
                widest = k;
                widest_area = area;
                widest_large = large;
            }
        }
        if widest == NOTHING { break; }
        let children = node_children(slots[widest]);
        slots[widest] = children.x;
        slots[used] = children.y;
        used++;
    }
    var ordered = vec4u(NOTHING);
    var place = 0u;
    var triangles = 0u;
    for (var k = 0u; k < used; k++) {
        if node_size(slots[k]) > LEAF_SIZE {
            ordered[place] = slots[k];
            place++;
        }
    }
    let inner = place;
    for (var k = 0u; k < used; k++) {
        let count = node_size(slots[k]);
        if count <= LEAF_SIZE {
            ordered[place] = slots[k];
            place++;
            triangles += count;
        }
    }
    links[number] = ordered;
    values[id.x] = vec2u(inner, triangles);
}
