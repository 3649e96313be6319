// Nodes' bricks from the voxels that they and their neighbours at the upper sides own (VCT 5.4.2: edge copy). Each texel has
// one owner, by whatever way it is reached, so that bricks agree where they touch.
{{ use("techniques/voxel_cones/octree.wgsl") }}
{{ use("techniques/voxel_cones/facing.wgsl") }}

fn write_texel(texel: vec3u, node: u32, corner: u32) {
    let packed = select(facing[8u * min(node, parameters.third) + corner], vec2u(0u), node == NO_NODE);
    textureStore(bricks_up, texel, vec4f(unpack_shares(packed.x), 0.0));
    textureStore(bricks_down, texel, vec4f(unpack_shares(packed.y), 0.0));
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + {{ row }}u * id.y;
    if index >= parameters.count { return; }
    let node = parameters.first + index;
    let code = codes[node];
    let log2_edge = log2_edge_of(code);
    let level = {{ depth - 1 }}u - log2_edge;
    let cell = vec3i(cell_of(code));
    let corner = brick_of(node);
    {% for o in range(8) %}
    let node_{{ o }} = {{ "node" if o == 0 else "node_at(level, cell + vec3i(%d, %d, %d))" % (o % 2, o // 2 % 2, o // 4) }};
    {% endfor %}
    {% for z in range(3) %}{% for y in range(3) %}{% for x in range(3) %}
    write_texel(corner + vec3u({{ x }}u, {{ y }}u, {{ z }}u), node_{{ x // 2 + 2 * (y // 2) + 4 * (z // 2) }}, {{ x % 2 + 2 * (y % 2) + 4 * (z % 2) }}u);
    {% endfor %}{% endfor %}{% endfor %}
}
