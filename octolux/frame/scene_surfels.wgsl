// Surfels of the scene's own surfaces, wherever they are: samples of triangles that keep their place on them as they move.
// Of the other side of a surface that is seen from both the area is negative: it reflects, but blocks nothing more.
{{ use("shaders/surface.wgsl") }}
{{ use("shaders/traits.wgsl") }}

// Of what a mask cuts out nothing is left; of what is translucent, its share.
fn coverage(alpha: f32, material: Material) -> f32 {
    return select(select(alpha, select(0.0, 1.0, alpha >= material.alpha_cutoff), material.alpha_mode == 1u), 1.0, material.alpha_mode == 0u);
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + {{ row }}u * id.y;
    if index >= range.count { return; }
    let sample = load_samples(index);
    let item = load_items(sample.triangle >> CLUSTER_BITS);
    let corners = load_triangles(item.first_triangle + (sample.triangle & ((1u << CLUSTER_BITS) - 1u)));
    let instance = load_instances(item.instance);
    let a = load_vertices(corners.a);
    let b = load_vertices(corners.b);
    let c = load_vertices(corners.c);
    let p = to_world(instance, a.position);
    let e1 = to_world(instance, b.position) - p;
    let e2 = to_world(instance, c.position) - p;
    let n = cross(e1, e2);
    let twice = length(n); // the triangle's area, two times
    let weights = vec3f(1.0 - sample.second - sample.third, sample.second, sample.third);
    let uv1 = b.uv - a.uv;
    let uv2 = c.uv - a.uv;
    // As wide in uv as a square of the sample's area is there.
    let share = abs(sample.share);
    let width = sqrt(0.5 * share * abs(uv1.x * uv2.y - uv1.y * uv2.x));
    var color = vec4f(1.0);
    {% if vertex_colors %}
    color = weights.x * unpack_color(a.color) + weights.y * unpack_color(b.color) + weights.z * unpack_color(c.color);
    {% endif %}
    let outward = normalize(select(n, -n, instance.flipped == 1u));
    let normal = select(outward, -outward, sample.share < 0.0);
    let position = p + sample.second * e1 + sample.third * e2;
    let hit = Hit(position, 0.0, normal, instance.material, normal, vec4f(1.0, 0.0, 0.0, 1.0),
        a.uv + sample.second * uv1 + sample.third * uv2, log2_footprint(vec2f(width, 0.0), vec2f(0.0, width)), color);
    let material = load_materials(hit.material);
    let base = base_color(hit, material);
    var albedo = base.rgb * (1.0 - material_roughness_metallic(material, hit.uv, hit.footprint).y);
    {% if unlit %}
    if material.unlit == 1u { albedo = vec3f(0.0); }
    {% endif %}
    let area = 0.5 * twice * share * coverage(base.a, material);
    let sided = select(area, -area, sample.share < 0.0);
    store_surfels(index, Vpl(position, pack_unit_vector(normal), vec3f(0.0), select(0.0, sided, twice > 0.0)));
    store_surfaces(index, pack_traits(albedo, instance));
}
