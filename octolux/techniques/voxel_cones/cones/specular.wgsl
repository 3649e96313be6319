// What a pixel reflects through a tight cone (simulator/voxels/cones.py, `specular_light`), weighted by its BRDF. At a share
// of the resolution only the light, and the normal and depth that it belongs to, are kept for reflect_all.wgsl.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/reflection.wgsl") }}
{{ use("techniques/voxel_cones/cones/tight_cone.wgsl") }}
{{ use("techniques/voxel_cones/cones/pixel.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(light_out)) { return; }
    let seen = seen_voxel(id.xy);
    let albedo = lobe_albedo(seen.surface, seen.to_eye);
    let wanted = seen.there && any(albedo > vec3f({{ darkest }}));
    let towards = reflected_direction(seen.surface, seen.to_eye);
    let traced = tight_cone(seen.start, towards, seen.geometric, {{ lobe }} * alpha_of(seen.surface), wanted);
    {% if sky %}
    let light = traced.radiance + {% if absorbs %}through_air(way_out(seen.start, towards)) * {% endif %}traced.left * environment_lobe(towards, alpha_of(seen.surface));
    {% else %}
    let light = traced.radiance;
    {% endif %}
    {% if resolution > 1 %}
    textureStore(light_out, id.xy, vec4f(light, 1.0));
    textureStore(place_out, id.xy, vec4f(seen.normal, select(0.0, seen.depth, wanted)));
    {% else %}
    textureStore(light_out, id.xy, vec4f(albedo * light, 1.0));
    {% endif %}
}
