// The third of a node's bricks (representation.py), which light does not change: what faces +z, -x, -y and -z of the voxels
// that it and its neighbours at the upper sides own.
{{ use("techniques/voxel_cones/octree/octree.wgsl") }}
{{ use("techniques/voxel_cones/bricks/facing.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = 3u * (id.x + {{ row }}u * id.y);
    if index >= parameters.count { return; }
    let around = around_node(codes[owners[index] >> 3u]);
    let texel = brick_texel(parameters.third + index + 2u);
    {% for o in range(8) %}
    let some_{{ o }} = around[{{ o }}] != NO_NODE;
    let node_{{ o }} = 8u * select(0u, around[{{ o }}], some_{{ o }});
    {% for corner in borrowed[o] %}
    {
        let packed = select(vec2u(0u), facing[node_{{ o }} + {{ corner }}u], some_{{ o }});
        let offset = vec3u({{ corner % 2 + 2 * (o % 2) }}u, {{ corner // 2 % 2 + 2 * (o // 2 % 2) }}u, {{ corner // 4 + 2 * (o // 4) }}u);
        textureStore(bricks, texel + offset, vec4f(unpack_shares(packed.x).z, unpack_shares(packed.y)));
    }
    {% endfor %}
    {% endfor %}
}
