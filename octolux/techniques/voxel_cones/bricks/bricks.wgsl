// Bricks from the voxels that nodes and their neighbours at the upper sides own (VCT 5.4.2: edge copy), as shares of a scale
// that all of a thread's bricks have. Each texel has one owner, by whatever way it is reached, so that bricks agree where they
// touch.
{{ use("techniques/voxel_cones/octree/octree.wgsl") }}
{{ use("techniques/voxel_cones/bricks/bright.wgsl") }}

// lit: place of a voxel's light in `light`.  faces: in `facing`, of what faces up or down, as the brick's way does.  there:
// both are.
struct Borrowed { lit: u32, faces: u32, there: bool }

// Of the representation: fn store_texel(texel: vec3u, way: u32, sent: vec3f, over: f32, from_voxel: Borrowed). over: what
// shares of the unit are multiplied by, as `sent` is.
{{ use(texels) }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let first = {{ together }}u * (id.x + {{ row }}u * id.y); // these stand together, in the update list too
    {% if listed %}
    if first >= lists[{{ 4 * depth + 3 }}] { return; }
    let index = update_list[first];
    {% else %}
    if first >= parameters.count { return; }
    let index = first;
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
        let from_voxel = Borrowed(lit_{{ o }} + {{ corner }}u, node_{{ o }} + {{ 2 * corner }}u, some_{{ o }});
        let offset = vec3u({{ corner % 2 + 2 * (o % 2) }}u, {{ corner // 2 % 2 + 2 * (o // 2 % 2) }}u, {{ corner // 4 + 2 * (o // 4) }}u);
        store_texel(texel + offset, way, over * light_{{ o }}_{{ corner }}, over, from_voxel);
    }
    {% endfor %}
    {% endfor %}
}
