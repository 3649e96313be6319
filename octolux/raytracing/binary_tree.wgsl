// Reading the binary tree (ploc.py). parameters.third: its leaves.

const NOTHING = 0xffffffffu;
const LEAF_SIZE = {{ leaf_size }}u;

fn node_size(node: u32) -> u32 {
    if node < parameters.third { return 1u; }
    return sizes[node - parameters.third];
}

fn node_children(node: u32) -> vec2u {
    return vec2u(tree[2u * node].w, tree[2u * node + 1u].w);
}

fn node_area(node: u32) -> f32 {
    let e = bitcast<vec3f>(tree[2u * node + 1u].xyz) - bitcast<vec3f>(tree[2u * node].xyz);
    return e.x * e.y + e.y * e.z + e.z * e.x;
}
