// A triangle's corners in world space, from its number as the visibility buffer has it (less one).

struct Corners { a: vec3f, b: vec3f, c: vec3f, instance: u32 }

fn placed(instance: Instance, vertex: u32) -> vec3f {
    let q = vec4f(load_vertices(vertex).position, 1.0);
    return vec3f(dot(instance.row0, q), dot(instance.row1, q), dot(instance.row2, q));
}

fn world_triangle(number: u32) -> Corners {
    let item = load_items(number >> {{ cluster_bits }}u);
    let corners = load_triangles(item.first_triangle + (number & {{ 2 ** cluster_bits - 1 }}u));
    let instance = load_instances(item.instance);
    return Corners(
        placed(instance, corners.a), placed(instance, corners.b), placed(instance, corners.c), item.instance
    );
}
