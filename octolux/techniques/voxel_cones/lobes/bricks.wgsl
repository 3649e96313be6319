// The first two of a node's bricks (representation.py) from the voxels that it and its neighbours at the upper sides own, as
// axial/bricks.wgsl: light and its moment, as shares of one scale, and what faces +x and +y. A moment of 0 is 128/255.
{{ use("techniques/voxel_cones/octree/octree.wgsl") }}
{{ use("techniques/voxel_cones/bricks/facing.wgsl") }}
{{ use("techniques/voxel_cones/bricks/bright.wgsl") }}
{{ use("techniques/voxel_cones/lobes/moment.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let first = 3u * (id.x + {{ row }}u * id.y); // a node's bricks stand together, in the update list too
    {% if listed %}
    if first >= lists[{{ 4 * depth + 3 }}] { return; }
    let index = update_list[first];
    {% else %}
    if first >= parameters.count { return; }
    let index = first;
    {% endif %}
    let owner = owners[index];
    let around = around_node(codes[owner >> 3u]);
    var brightest = vec3f(0.0);
    {% for o in range(8) %}
    let some_{{ o }} = around[{{ o }}] != NO_NODE;
    let lit_{{ o }} = 8u * select(0u, brick_there(around[{{ o }}], 0u), some_{{ o }});
    let node_{{ o }} = 16u * select(0u, around[{{ o }}], some_{{ o }});
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
        let moment = select(vec3f(0.0), unpack_moment(light[lit_{{ o }} + {{ 8 + corner }}u]), some_{{ o }});
        let signed = {{ 128 / 255 }} + {{ 127 / 255 }} * over * moment;
        let up = select(vec3f(0.0), unpack_shares(facing[node_{{ o }} + {{ 2 * corner }}u]), some_{{ o }});
        let offset = vec3u({{ corner % 2 + 2 * (o % 2) }}u, {{ corner // 2 % 2 + 2 * (o // 2 % 2) }}u, {{ corner // 4 + 2 * (o // 4) }}u);
        textureStore(bricks, texel + offset, vec4f(over * light_{{ o }}_{{ corner }}, signed.x));
        textureStore(bricks, texel + vec3u(3u, 0u, 0u) + offset, vec4f(signed.yz, up.xy));
    }
    {% endfor %}
    {% endfor %}
}
