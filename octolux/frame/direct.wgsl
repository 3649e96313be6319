// Direct light of every directional, spot and point light, with shadows: outgoing radiance towards the camera.
// A few lights are unrolled: with constant indices a software adapter reads lights and views once for all pixels.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/brdf.wgsl") }}
{{ use("shaders/lights.wgsl") }}

struct Point { position: vec3f, to_eye: vec3f, surface: Surface }

// Radiance under light from unit direction l that brings `illuminance`, of which `lit` arrives.
fn reflected(p: Point, l: vec3f, illuminance: vec3f, lit: f32) -> vec3f {
    let facing = select(0.0, max(dot(p.surface.normal, l), 0.0), dot(p.surface.geometric_normal, l) > 0.0);
    return brdf(p.surface, l, p.to_eye) * illuminance * (facing * lit);
}

fn from_directional(p: Point, index: u32, view: u32) -> vec3f {
    let light = lights[index];
    let lit = lit_fraction(view, p.position, p.surface.geometric_normal, light.texel);
    return reflected(p, -light.direction, directional_illuminance(light), lit);
}

fn from_spot(p: Point, index: u32, view: u32) -> vec3f {
    let light = lights[index];
    let to_light = light.position - p.position;
    let l = normalize(to_light);
    let footprint = light.texel * -dot(to_light, light.direction);
    let lit = lit_fraction(view, p.position, p.surface.geometric_normal, footprint) * spot_attenuation(light, l);
    return reflected(p, l, point_illuminance(light, to_light), lit);
}

fn from_point(p: Point, index: u32, first_view: u32) -> vec3f {
    let light = lights[index];
    let to_light = light.position - p.position;
    let a = abs(to_light);
    let footprint = light.texel * max(a.x, max(a.y, a.z));
    let lit = lit_fraction(first_view + cube_face(-to_light), p.position, p.surface.geometric_normal, footprint);
    return reflected(p, normalize(to_light), point_illuminance(light, to_light), lit);
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) pixel: vec3u) {
    if any(pixel.xy >= textureDimensions(depth_map)) { return; }
    let depth = textureLoad(depth_map, pixel.xy, 0).x;
    if depth <= 0.0 {
        textureStore(direct_out, pixel.xy, vec4f(0.0));
        return;
    }
    let ray = view_ray(views[0], vec2f(pixel.xy) + 0.5);
    let surface = unpack_surface(textureLoad(surface_map, pixel.xy, 0));
    let p = Point(ray.origin + depth * ray.direction, -normalize(ray.direction), surface);
    var radiance = vec3f(0.0);
    {% for kind, first, count, first_view, views_each in groups %}
    {% if unrolled %}
    {% for i in range(count) %}
    radiance += from_{{ kind }}(p, {{ first + i }}u, {{ first_view + i * views_each }}u);
    {% endfor %}
    {% elif count %}
    for (var i = 0u; i < {{ count }}u; i++) {
        radiance += from_{{ kind }}(p, {{ first }}u + i, {{ first_view }}u + i * {{ views_each }}u);
    }
    {% endif %}
    {% endfor %}
    textureStore(direct_out, pixel.xy, vec4f(radiance, 1.0));
}
