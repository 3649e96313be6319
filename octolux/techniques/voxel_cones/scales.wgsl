// The brightest that a brick holds, as the code of its scale: bricks keep light as shares of it, in 8 bits.
{{ use("techniques/voxel_cones/octree.wgsl") }}
{{ use("techniques/voxel_cones/bright.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + {{ row }}u * id.y;
    if index >= parameters.count { return; }
    let owner = owners[index];
    let around = around_node(codes[owner >> 3u]);
    var brightest = vec3f(0.0);
    {% for o in range(8) %}
    {
        let brick = brick_there(around[{{ o }}], owner & 7u);
        if brick != NO_NODE {
            {% for corner in borrowed[o] %}
            brightest = max(brightest, unpack_bright(light[8u * brick + {{ corner }}u]));
            {% endfor %}
        }
    }
    {% endfor %}
    scales[index] = scale_code(bitcast<f32>(parameters.second) * max(max(brightest.r, brightest.g), brightest.b));
}
