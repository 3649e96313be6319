// Bricks from the voxels that nodes and their neighbours at the upper sides own (VCT 5.4.2: edge copy): light that is sent
// one way, as a share of the brick's scale, and the share of the section that faces there. Each texel has one owner, by
// whatever way it is reached, so that bricks agree where they touch.
{{ use("techniques/voxel_cones/octree.wgsl") }}
{{ use("techniques/voxel_cones/facing.wgsl") }}
{{ use("techniques/voxel_cones/bright.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + {{ row }}u * id.y;
    if index >= parameters.count { return; }
    let owner = owners[index];
    let way = owner & 7u;
    let around = around_node(codes[owner >> 3u]);
    let texel = brick_texel(index);
    let over = bitcast<f32>(parameters.second) / scale_of(scales[index]);
    {% for o in range(8) %}
    {
        let brick = brick_there(around[{{ o }}], way);
        let some = brick != NO_NODE;
        let node = select(0u, around[{{ o }}], some);
        let lit = select(0u, brick, some);
        {% for corner in borrowed[o] %}
        {
            let share = share_of_way(facing[8u * node + {{ corner }}u], way);
            let value = vec4f(over * unpack_bright(light[8u * lit + {{ corner }}u]), share);
            let offset = vec3u({{ corner % 2 + 2 * (o % 2) }}u, {{ corner // 2 % 2 + 2 * (o // 2 % 2) }}u, {{ corner // 4 + 2 * (o // 4) }}u);
            textureStore(bricks, texel + offset, select(vec4f(0.0), value, some));
        }
        {% endfor %}
    }
    {% endfor %}
}
