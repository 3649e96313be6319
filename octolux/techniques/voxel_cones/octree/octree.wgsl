// The sparse octree: which of a level's cells have nodes, and where a node's bricks lie. All of the layout is here, in
// octree.py and in bricks.py.
//
// Nodes are numbered by their codes, so those of a level stand together, and in Morton order. A texel of `directory`
// says of 32 cells which have nodes, and the number of the first of these: children, parent and neighbours of a node, the
// pointers of the thesis (VCT 5.2.2), are looked up there by their codes, without a descent.
//
// A node has a brick for each of the six ways that anything in it faces, or bricks of lobes (representation.py). The 3^3
// texels of each are the middles of voxels 2 j to 2 j + 2 of its level, where j is its cell: so what lies between them is
// filtered by hardware.
{{ use("techniques/voxel_cones/octree/codes.wgsl") }}

const NO_NODE = 0xffffffffu;

{% for part in parts %}
fn {{ part }}node_of(code: u32) -> u32 {
    let word = code >> 5u;
    let entry = textureLoad({{ part }}directory, vec2u(word & {{ directory_row - 1 }}u, word / {{ directory_row }}u){{ ", 0" if part }}).xy;
    let bit = 1u << (code & 31u);
    return select(NO_NODE, entry.y + countOneBits(entry.x & (bit - 1u)), (entry.x & bit) != 0u);
}
{% endfor %}

// Numbers of a node's children, which stand together: the first, and how many.
struct Children { first: u32, count: u32 }

fn children_of(code: u32) -> Children {
    let word = code >> 2u; // eight codes are a byte
    let entry = textureLoad(directory, vec2u(word & {{ directory_row - 1 }}u, word / {{ directory_row }}u)).xy;
    let shift = 8u * (code & 3u);
    return Children(entry.y + countOneBits(entry.x & ((1u << shift) - 1u)), countOneBits((entry.x >> shift) & 255u));
}

// A node and its neighbours at the upper sides: number k at (k & 1, k >> 1 & 1, k >> 2).
fn around_node(code: u32) -> array<u32, 8> {
    let log2_edge = log2_edge_of(code);
    let cell = cell_of(code);
    let edge = 1u << log2_edge;
    var nodes: array<u32, 8>;
    {% for o in range(8) %}
    {
        let other = cell + vec3u({{ o % 2 }}u, {{ o // 2 % 2 }}u, {{ o // 4 }}u);
        nodes[{{ o }}] = select(NO_NODE, node_of(code_of(log2_edge, min(other, vec3u(edge - 1u)))), all(other < vec3u(edge)));
    }
    {% endfor %}
    return nodes;
}

// ways: of a node, number of its first brick << 6 | which ways it has; NO_NODE for a way that it has not.
fn brick_of_way(ways: u32, way: u32) -> u32 {
    let bit = 1u << way;
    return select(NO_NODE, (ways >> 6u) + countOneBits(ways & (bit - 1u)), (ways & bit) != 0u);
}

{% if "ways" in reads %}
fn brick_there(node: u32, way: u32) -> u32 {
    return select(NO_NODE, brick_of_way(ways[select(node, 0u, node == NO_NODE)], way), node != NO_NODE);
}
{% endif %}

// The first texel of a brick.
fn brick_texel(brick: u32) -> vec3u {
    return 3u * vec3u(brick % {{ bricks_row }}u, brick / {{ bricks_row }}u % {{ bricks_row }}u, brick / {{ bricks_row**2 }}u);
}

// Scales are the first bits of floats, exponent and two of the mantissa, from 2^-32 (code 0) to below 2^32.
fn scale_code(brightest: f32) -> u32 {
    let rounded_up = i32((bitcast<u32>(brightest) + 0x1fffffu) >> 21u);
    return u32(clamp(rounded_up - 380, 0, 255)); // 380 is 4 (127 - 32)
}

fn scale_of(code: u32) -> f32 { return bitcast<f32>((code + 380u) << 21u); }

{% if "nodes" in reads %}
// `sample`, of the representation, has sample_node and facing_node.
//
// position: in voxels of level 0 from the cube's corner, inside it. Of a level the cell of 2^3 voxels' edges around it,
// whose corners are middles of voxels; half a voxel from the border inwards the outermost voxels hold. A filter's weights have
// 8 bits: `within` has as many, and a quarter, so that a sample is the same bits wherever its brick lies in the texture.
struct Place { code: u32, within: vec3f }

fn place_at(position: vec3f, level: u32) -> Place {
    let log2_edge = {{ depth - 1 }}u - level;
    let edge = f32(2u << log2_edge);
    let at = clamp(position * exp2(-f32(level)) - 0.5, vec3f(0.0), vec3f(edge - 1.0));
    let cell = min(vec3u(0.5 * at), vec3u((1u << log2_edge) - 1u));
    let within = at - vec3f(2u * cell) + 0.5;
    return Place(code_of(log2_edge, cell), (floor(256.0 * within) + 0.25) / 256.0);
}

// Whether there is nothing around a position on this level, and so on finer ones.
fn is_empty(position: vec3f, level: u32) -> bool {
    let code = place_at(position, level).code;
    return node_of(code) == NO_NODE;
}

{{ use(sample) }}

// What is met around a position on a way along the unit vector `direction` as long as an edge of the level's voxels:
// radiance times opacity, and opacity. It crosses |d| of the sections across each axis, of what looks against it.
fn sample_voxels(position: vec3f, level: u32, direction: vec3f) -> vec4f {
    let place = place_at(position, level);
    let number = node_of(place.code);
    if number == NO_NODE { return vec4f(0.0); }
    return sample_node(number, place, direction);
}

// Opacity alone of ways along each axis: what faces against the parts of `direction`, times these.
fn facing_voxels(position: vec3f, level: u32, direction: vec3f) -> vec3f {
    let place = place_at(position, level);
    let number = node_of(place.code);
    if number == NO_NODE { return vec3f(0.0); }
    return facing_node(number, place, direction);
}
{% endif %}
