// Given rays through the BVH: (origin, t_min), (direction, t_max) each. An any-hit query writes 1 in `id` where
// something is hit.
{{ use("raytracing/traverse.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let number = id.x + id.y * {{ row }}u;
    if number >= arrayLength(&hits) { return; }
    let from_ = rays[2u * number];
    let towards = rays[2u * number + 1u];
    {% if any_hit %}
    let met = any_hit(from_.xyz, towards.xyz, from_.w, towards.w, {{ alpha_seed }}u + number);
    hits[number] = vec4u(0u, select(0u, 1u, met), 0u, 0u);
    {% else %}
    let hit = closest_hit(from_.xyz, towards.xyz, from_.w, towards.w, {{ alpha_seed }}u + number, {{ "true" if cull_back else "false" }});
    hits[number] = vec4u(bitcast<u32>(hit.t), hit.id, bitcast<u32>(hit.b1), bitcast<u32>(hit.b2));
    {% endif %}
    {% if bvh_counts is defined %}
    hits[number].z = bitcast<u32>(f32(bvh_visits.x));
    hits[number].w = bitcast<u32>(f32(bvh_visits.y));
    {% endif %}
}
