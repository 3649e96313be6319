// From a triangle's number and a ray to the surface there: what the rasteriser writes (shaders/visibility.wgsl) is led
// back to position, normals and texture coordinates. Needs the scene's bind group.
{{ use("shaders/octahedral.wgsl") }}
{{ use("shaders/view.wgsl") }}
{{ use("shaders/material.wgsl") }}

const CLUSTER_BITS = {{ cluster_bits }}u;

// Where a ray meets a triangle. footprint: of the pixel in uv, see log2_footprint.
struct Hit {
    position: vec3f,
    depth: f32,
    geometric_normal: vec3f,
    material: u32,
    normal: vec3f,
    tangent: vec4f,
    uv: vec2f,
    footprint: f32,
    color: vec4f,
}

fn to_world(instance: Instance, p: vec3f) -> vec3f {
    let q = vec4f(p, 1.0);
    return vec3f(dot(instance.row0, q), dot(instance.row1, q), dot(instance.row2, q));
}

fn direction_to_world(instance: Instance, d: vec3f) -> vec3f {
    return vec3f(dot(instance.row0.xyz, d), dot(instance.row1.xyz, d), dot(instance.row2.xyz, d));
}

// Normals go with the cofactor matrix, whose rows are cross products of the rows; its sign is that of the determinant.
fn normal_to_world(instance: Instance, n: vec3f) -> vec3f {
    let a = instance.row0.xyz;
    let b = instance.row1.xyz;
    let c = instance.row2.xyz;
    let turned = vec3f(dot(cross(b, c), n), dot(cross(c, a), n), dot(cross(a, b), n));
    return normalize(select(turned, -turned, instance.flipped == 1u));
}

fn unpack_tangent(packed: u32) -> vec4f {
    return vec4f(unpack_unit_vector(packed), select(1.0, -1.0, (packed & 1u) == 1u));
}

{% if vertex_colors %}
// Square roots of the linear values are stored (gpu_scene/packing.py).
fn unpack_color(packed: u32) -> vec4f {
    let root = unpack4x8unorm(packed);
    return root * root;
}
{% endif %}

// `id` is what the rasteriser wrote, not 0. `origin_dx` and so on: change of the ray from pixel to pixel.
fn hit_triangle(id: u32, ray: Ray, to_right: Ray, down: Ray) -> Hit {
    let item = load_items((id - 1u) >> CLUSTER_BITS);
    let corners = load_triangles(item.first_triangle + ((id - 1u) & ((1u << CLUSTER_BITS) - 1u)));
    let instance = load_instances(item.instance);
    let a = load_vertices(corners.a);
    let b = load_vertices(corners.b);
    let c = load_vertices(corners.c);
    let p = to_world(instance, a.position);
    let e1 = to_world(instance, b.position) - p;
    let e2 = to_world(instance, c.position) - p;
    let n = cross(e1, e2);
    let inverse_square = 1.0 / dot(n, n);
    // Barycentric coordinates are linear in the point: their gradients in the plane of the triangle.
    let g1 = cross(e2, n) * inverse_square;
    let g2 = cross(n, e1) * inverse_square;
    let slope = dot(n, ray.direction);
    let inverse_slope = select(1.0 / slope, 0.0, slope == 0.0);
    let depth = dot(n, p - ray.origin) * inverse_slope;
    let position = ray.origin + depth * ray.direction;
    let b1 = dot(position - p, g1);
    let b2 = dot(position - p, g2);
    // The point's motion with the pixel (Igehy 1999, ray differentials of a plane).
    let step_x = to_right.origin + depth * to_right.direction;
    let step_y = down.origin + depth * down.direction;
    let move_x = step_x - ray.direction * (dot(n, step_x) * inverse_slope);
    let move_y = step_y - ray.direction * (dot(n, step_y) * inverse_slope);
    let uv1 = b.uv - a.uv;
    let uv2 = c.uv - a.uv;
    let weights = vec3f(1.0 - b1 - b2, b1, b2);
    let normal = weights.x * unpack_unit_vector(a.normal) + weights.y * unpack_unit_vector(b.normal)
        + weights.z * unpack_unit_vector(c.normal);
    var tangent = vec4f(1.0, 0.0, 0.0, 1.0);
    {% if "normal_texture" in slots %}
    let ta = unpack_tangent(a.tangent);
    tangent = vec4f(weights.x * ta.xyz + weights.y * unpack_tangent(b.tangent).xyz
        + weights.z * unpack_tangent(c.tangent).xyz, ta.w);
    // A mirrored instance turns cross(normal, tangent) round, but not what it shows.
    let handedness = select(tangent.w, -tangent.w, instance.flipped == 1u);
    tangent = vec4f(direction_to_world(instance, tangent.xyz), handedness);
    {% endif %}
    var color = vec4f(1.0);
    {% if vertex_colors %}
    color = weights.x * unpack_color(a.color) + weights.y * unpack_color(b.color) + weights.z * unpack_color(c.color);
    {% endif %}
    let outward = normalize(select(n, -n, instance.flipped == 1u));
    return Hit(
        position, depth, outward, instance.material, normal_to_world(instance, normal), tangent,
        a.uv + b1 * uv1 + b2 * uv2,
        log2_footprint(
            uv1 * dot(move_x, g1) + uv2 * dot(move_x, g2),
            uv1 * dot(move_y, g1) + uv2 * dot(move_y, g2),
        ),
        color,
    );
}

// Base colour and alpha of the surface: material, texture and vertex colour.
fn base_color(hit: Hit, material: Material) -> vec4f {
    return hit.color * material_base_color(material, hit.uv, hit.footprint);
}

// The shading normal with the normal map, in world space.
fn mapped_normal(hit: Hit, material: Material) -> vec3f {
    {% if "normal_texture" in slots %}
    let local = material_normal(material, hit.uv, hit.footprint);
    let t = normalize(hit.tangent.xyz - hit.normal * dot(hit.normal, hit.tangent.xyz));
    let bitangent = cross(hit.normal, t) * hit.tangent.w;
    return normalize(t * local.x + bitangent * local.y + hit.normal * local.z);
    {% else %}
    return hit.normal;
    {% endif %}
}
