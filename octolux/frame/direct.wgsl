// Direct light of every directional, spot and point light, with shadows: outgoing radiance towards the camera.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/brdf.wgsl") }}
{{ use("shaders/lights.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) pixel: vec3u) {
    if any(pixel.xy >= textureDimensions(depth_map)) { return; }
    let depth = textureLoad(depth_map, pixel.xy, 0).x;
    if depth <= 0.0 {
        textureStore(direct_out, pixel.xy, vec4f(0.0));
        return;
    }
    let ray = view_ray(views[0], vec2f(pixel.xy) + 0.5);
    let position = ray.origin + depth * ray.direction;
    let v = -normalize(ray.direction);
    let s = unpack_surface(textureLoad(surface_map, pixel.xy, 0));
    var radiance = vec3f(0.0);
    for (var i = 0u; i < counts.directional; i++) {
        let light = lights[i];
        let l = -light.direction;
        let shadow = lit_fraction(light.view, position, s.geometric_normal, light.texel);
        radiance += brdf(s, l, v) * directional_illuminance(light) * max(dot(s.normal, l), 0.0)
            * select(0.0, shadow, dot(s.geometric_normal, l) > 0.0);
    }
    for (var i = counts.directional; i < counts.directional + counts.spot; i++) {
        let light = lights[i];
        let to_light = light.position - position;
        let l = normalize(to_light);
        let footprint = light.texel * -dot(to_light, light.direction);
        let shadow = lit_fraction(light.view, position, s.geometric_normal, footprint) * spot_attenuation(light, l);
        radiance += brdf(s, l, v) * point_illuminance(light, to_light) * max(dot(s.normal, l), 0.0)
            * select(0.0, shadow, dot(s.geometric_normal, l) > 0.0);
    }
    let points = counts.directional + counts.spot;
    for (var i = points; i < points + counts.point; i++) {
        let light = lights[i];
        let to_light = light.position - position;
        let l = normalize(to_light);
        let a = abs(to_light);
        let footprint = light.texel * max(a.x, max(a.y, a.z));
        let face = light.view + cube_face(-to_light);
        let shadow = lit_fraction(face, position, s.geometric_normal, footprint);
        radiance += brdf(s, l, v) * point_illuminance(light, to_light) * max(dot(s.normal, l), 0.0)
            * select(0.0, shadow, dot(s.geometric_normal, l) > 0.0);
    }
    textureStore(direct_out, pixel.xy, vec4f(radiance, 1.0));
}
