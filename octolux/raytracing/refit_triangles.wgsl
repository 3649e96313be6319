// Each triangle's corners in world space: (a, number), (b, flags of its instance), (c, 0).
{{ use("raytracing/world_triangle.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= parameters.count { return; }
    let number = order[id.x];
    let t = world_triangle(number);
    let word = 1u + 3u * id.x;
    bvh[word] = vec4u(bitcast<vec3u>(t.a), number + 1u);
    bvh[word + 1u] = vec4u(bitcast<vec3u>(t.b), flags[t.instance]);
    bvh[word + 2u] = vec4u(bitcast<vec3u>(t.c), 0u);
}
