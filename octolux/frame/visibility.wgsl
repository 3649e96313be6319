// Draws cluster after cluster and writes which triangle is nearest: item and triangle, plus one; 0 is nothing.
{% if peels %}
// Of what lies behind the map `nearer`. Depths of one triangle are the same in all renderings, to the bit, as positions are
// invariant: it is not behind itself, and what is a step of the depth's format farther is. No bias has to be guessed.
{% endif %}
{{ use("shaders/surface.wgsl") }}

struct Corner {
    @builtin(position) @invariant position: vec4f, // of one place in all variants: peeling compares depths
    @location(0) @interpolate(flat) id: u32,
    {% if masked %}
    @location(1) uv: vec2f,
    @location(2) @interpolate(flat) material: u32,
    {% if vertex_colors %}
    @location(3) alpha: f32,
    {% endif %}
    {% if blended %}
    @location(4) position_ws: vec3f,
    {% endif %}
    {% endif %}
}

@vertex
fn vertex(@builtin(vertex_index) vertex_index: u32, @builtin(instance_index) index: u32) -> Corner {
    let item_index = drawn[index];
    let item = load_items(item_index);
    let triangle = vertex_index / 3u;
    var corner: Corner;
    if triangle >= item.triangle_count {
        corner.position = vec4f(0.0, 0.0, 0.0, 1.0); // three times the same point: nothing is drawn
        return corner;
    }
    let instance = load_instances(item.instance);
    var k = vertex_index % 3u;
    if instance.flipped == 1u { k = (3u - k) % 3u; } // a mirrored triangle keeps its front
    let corners = load_triangles(item.first_triangle + triangle);
    let vertex = load_vertices(vec3u(corners.a, corners.b, corners.c)[k]);
    let position_ws = to_world(instance, vertex.position);
    corner.position = view.view_projection * vec4f(position_ws, 1.0);
    corner.id = (item_index << CLUSTER_BITS | triangle) + 1u;
    {% if masked %}
    corner.uv = vertex.uv;
    corner.material = instance.material;
    {% if vertex_colors %}
    corner.alpha = unpack_color(vertex.color).a;
    {% endif %}
    {% if blended %}
    corner.position_ws = position_ws;
    {% endif %}
    {% endif %}
    return corner;
}

{% if masked %}
{% if blended %}
{{ use("shaders/hashed_alpha.wgsl") }}
{% endif %}
fn discard_if_masked(corner: Corner) {
    let footprint = log2_footprint(dpdx(corner.uv), dpdy(corner.uv));
    let material = load_materials(corner.material);
    var alpha = material_base_color(material, corner.uv, footprint).a;
    {% if vertex_colors %}
    alpha *= corner.alpha;
    {% endif %}
    var cut = alpha < material.alpha_cutoff;
    {% if blended %}
    let fixed_threshold = hashed_threshold(corner.position_ws);
    let threshold = select(
        fixed_threshold, sample_threshold(corner.position.xy, corner.id, view.sample, max(view.samples, 1u)),
        view.samples > 1u,
    );
    if material.alpha_mode == 2u { cut = alpha <= threshold; }
    {% endif %}
    if cut { discard; }
}
{% endif %}

{% if writes_id %}
@fragment
fn fragment(corner: Corner) -> @location(0) u32 {
    {% if peels %}
    if corner.position.z >= textureLoad(nearer, vec2u(corner.position.xy), 0) { discard; } // reverse z: less is farther
    {% endif %}
    {% if masked %}
    discard_if_masked(corner);
    {% endif %}
    return corner.id;
}
{% else %}
@fragment
fn fragment(corner: Corner) {
    {% if masked %}
    discard_if_masked(corner);
    {% endif %}
}
{% endif %}
