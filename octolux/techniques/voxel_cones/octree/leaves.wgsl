// Voxels of level 0: where they are in the pools, and which one a point of a surface lies in.
{{ use("techniques/voxel_cones/octree/octree.wgsl") }}
{{ use("techniques/voxel_cones/octree/columns.wgsl") }}

// node: of level 0, and which of its eight voxels; number: of the voxel's record. NO_NODE where it is not occupied.  mask:
// which of the node's voxels are, 0 where it is missing.
struct Leaf { node: u32, corner: u32, number: u32, mask: u32 }

{% for part in parts %}
fn {{ part }}leaf_at(voxel: vec3i) -> Leaf {
    let cell = vec3u(clamp(voxel, vec3i(0), vec3i({{ 2**depth - 1 }})));
    let corner = (cell.x & 1u) | ((cell.y & 1u) << 1u) | ((cell.z & 1u) << 2u);
    let node = {{ part }}node_of(code_of({{ depth - 1 }}u, cell >> vec3u(1u)));
    let leaf = load_{{ part }}leaves(select(node - {{ part }}cube.first_leaf, 0u, node == NO_NODE));
    let there = node != NO_NODE && ((leaf >> corner) & 1u) == 1u && all(vec3i(cell) == voxel);
    let number = (leaf >> 8u) + countOneBits(leaf & ((1u << corner) - 1u));
    return Leaf(select(NO_NODE, node, there), corner, number, select(leaf & 255u, 0u, node == NO_NODE));
}
{% endfor %}

// leaf: in the own octree; some: the voxel is occupied, in whichever. What moves has all of the nodes that it lies in.
struct Found { leaf: Leaf, some: bool }

fn found_at(voxel: vec3i) -> Found {
    var leaf = leaf_at(voxel);
    {% if parts|length > 1 %}
    let other = {{ parts[1] }}leaf_at(voxel);
    let own = {{ "leaf.mask != 0u" if parts[1] == "static_" else "other.mask == 0u" }};
    let some = select(other.node, leaf.node, own) != NO_NODE;
    leaf.node = select(NO_NODE, leaf.node, own);
    return Found(leaf, some);
    {% else %}
    return Found(leaf, leaf.node != NO_NODE);
    {% endif %}
}

// The voxel of a point, in voxels, on a surface across `normal`: that of the column's fragment, as its plane passes the
// middle. Where the surface bends, or another point of it was taken, it is the next one farther, or nearer.
fn leaf_of_surface(p: vec3f, normal: vec3f) -> Leaf {
    let axis = dominant_axis(normal);
    let voxel = turned(floor(p), axis);
    let n = turned(normal, axis);
    let at = turned(p, axis);
    let depth = at.z - dot(voxel.xy + 0.5 - at.xy, n.xy / n.z);
    let middle = vec3i(vec3f(voxel.xy, floor(depth + {{ bias }})));
    let found = found_at(turned_back(middle, axis));
    if found.some { return found.leaf; }
    let above = found_at(turned_back(middle + vec3i(0, 0, 1), axis));
    if above.some { return above.leaf; }
    return found_at(turned_back(middle - vec3i(0, 0, 1), axis)).leaf;
}
