// Step 2: a wide node's inner children and the triangles of its leaves get their places, each a run of their own.
// A link is (first inner child, first triangle, what the children are: four bits each, 0 nothing, 1 to {{ leaf_size }} a leaf
// of so many triangles, 8 an inner node; unused). Until they have theirs, inner children hold their node of the tree.
{{ use("raytracing/binary_tree.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= parameters.count { return; }
    let number = parameters.first + id.x;
    let place = values[id.x] + totals[id.x / {{ block }}u];
    let first_child = parameters.first + parameters.count + place.x;
    let first_triangle = parameters.second + place.y;
    let children = links[number];
    var kinds = 0u;
    var inner = 0u;
    var written = first_triangle;
    for (var k = 0u; k < 4u; k++) {
        let child = children[k];
        if child == NOTHING { break; }
        let count = node_size(child);
        if count > LEAF_SIZE {
            links[first_child + inner] = vec4u(child, 0u, 0u, 0u);
            inner++;
            kinds |= 8u << (4u * k);
            continue;
        }
        kinds |= count << (4u * k);
        var waiting: array<u32, {{ leaf_size }}>;
        waiting[0] = child;
        var depth = 1u;
        while depth > 0u {
            depth--;
            let node = waiting[depth];
            let below = node_children(node);
            if node < parameters.third {
                order[written] = ids[below.x];
                written++;
            } else {
                waiting[depth] = below.y;
                waiting[depth + 1u] = below.x;
                depth += 2u;
            }
        }
    }
    links[number] = vec4u(first_child, first_triangle, kinds, 0u);
}
