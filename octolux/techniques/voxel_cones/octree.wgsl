// The sparse octree: which of a level's cells have nodes, and where a node's brick lies. All of the layout is here and in
// octree.py.
//
// Nodes are numbered by their codes, so those of a level stand together, and in Morton order. A texel of `directory`
// says of 32 cells which have nodes, and the number of the first of these: children, parent and neighbours of a node, the
// pointers of the thesis (VCT 5.2.2), are looked up there by their codes, without a descent.
{{ use("techniques/voxel_cones/codes.wgsl") }}

const NO_NODE = 0xffffffffu;

fn node_of(code: u32) -> u32 {
    let word = code >> 5u;
    let entry = textureLoad(directory, vec2u(word & {{ directory_row - 1 }}u, word / {{ directory_row }}u)).xy;
    let bit = 1u << (code & 31u);
    return select(NO_NODE, entry.y + countOneBits(entry.x & (bit - 1u)), (entry.x & bit) != 0u);
}

// The node of a cell of `level`; cells outside the cube have none.
fn node_at(level: u32, cell: vec3i) -> u32 {
    let log2_edge = {{ depth - 1 }}u - level;
    let inside = all(cell >= vec3i(0)) && all(cell < vec3i(1i << log2_edge));
    let node = node_of(code_of(log2_edge, vec3u(clamp(cell, vec3i(0), vec3i((1i << log2_edge) - 1)))));
    return select(NO_NODE, node, inside);
}

// A node's brick: 3^3 texels, for the middles of voxels 2 j to 2 j + 2 of its level, where j is its cell.
fn brick_of(node: u32) -> vec3u {
    return 3u * vec3u(node & {{ bricks - 1 }}u, (node >> {{ log2_bricks }}u) & {{ bricks - 1 }}u, node >> {{ 2 * log2_bricks }}u);
}

{% if sampled is defined %}
// Where to read trilinear values: texel of the bricks' textures, from their corner, and whether there is a node.
struct Place { texel: vec3f, found: bool }

// p: in voxels of `level` from the cube's corner, inside it. Half a voxel from the border the outermost voxels hold.
fn place_at(level: u32, p: vec3f) -> Place {
    let edge = f32(2u << ({{ depth - 1 }}u - level));
    let at = clamp(p - 0.5, vec3f(0.0), vec3f(edge - 1.0));
    let cell = min(vec3u(0.5 * at), vec3u(u32(edge) / 2u - 1u));
    let node = node_of(code_of({{ depth - 1 }}u - level, cell));
    return Place(vec3f(brick_of(node)) + (at - vec3f(2u * cell)) + 0.5, node != NO_NODE);
}
{% endif %}
