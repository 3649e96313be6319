// Bricks from the voxels that nodes and their neighbours at the upper sides own (VCT 5.4.2: edge copy): light that is sent
// one way, as a share of the brick's scale, and the share of the section that faces there. Each texel has one owner, by
// whatever way it is reached, so that bricks agree where they touch.
{{ use("techniques/voxel_cones/octree/octree.wgsl") }}
{{ use("techniques/voxel_cones/bricks/facing.wgsl") }}
{{ use("techniques/voxel_cones/bricks/bright.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let thread = id.x + {{ row }}u * id.y;
    {% if listed %}
    if thread >= lists[{{ 4 * depth + 3 }}] { return; }
    let index = update_list[thread];
    {% else %}
    if thread >= parameters.count { return; }
    let index = thread;
    {% endif %}
    let owner = owners[index];
    let way = owner & 7u;
    let around = around_node(codes[owner >> 3u]);
    var brightest = vec3f(0.0);
    {% for o in range(8) %}
    let brick_{{ o }} = brick_there(around[{{ o }}], way);
    let some_{{ o }} = brick_{{ o }} != NO_NODE;
    let lit_{{ o }} = 8u * select(0u, brick_{{ o }}, some_{{ o }});
    let node_{{ o }} = 16u * select(0u, around[{{ o }}], some_{{ o }}) + (way & 1u);
    {% for corner in borrowed[o] %}
    let light_{{ o }}_{{ corner }} = select(vec3f(0.0), unpack_bright(light[lit_{{ o }} + {{ corner }}u]), some_{{ o }});
    brightest = max(brightest, light_{{ o }}_{{ corner }});
    {% endfor %}
    {% endfor %}
    let unit = bitcast<f32>(parameters.second);
    let code = scale_code(unit * max(max(brightest.r, brightest.g), brightest.b));
    let over = unit / scale_of(code);
    scales[index] = code;
    let texel = brick_texel(parameters.third + index);
    {% for o in range(8) %}
    {% for corner in borrowed[o] %}
    {
        let share = select(0.0, share_of(facing[node_{{ o }} + {{ 2 * corner }}u], way >> 1u), some_{{ o }});
        let offset = vec3u({{ corner % 2 + 2 * (o % 2) }}u, {{ corner // 2 % 2 + 2 * (o // 2 % 2) }}u, {{ corner // 4 + 2 * (o // 4) }}u);
        textureStore(bricks, texel + offset, vec4f(over * light_{{ o }}_{{ corner }}, share));
    }
    {% endfor %}
    {% endfor %}
}
