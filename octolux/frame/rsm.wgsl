// Reflective shadow maps: one VPL per {{ stride }} x {{ stride }} shadow-map texels, led back to its surface from the
// triangle number that the shadow map's own rendering wrote. The texel taken walks through the block in the order of a
// magic-square-like permutation, so that neighbouring blocks take different texels and their mean is the block's centre.
{{ use("shaders/surface.wgsl") }}
{{ use("shaders/lights.wgsl") }}

// Signed solid angle of the rectangle from the axis to (x, y) at distance 1 (Van Oosterom and Strackee 1983).
fn corner_solid_angle(x: f32, y: f32) -> f32 { return atan2(x * y, sqrt(x * x + y * y + 1.0)); }

fn rectangle_solid_angle(low: vec2f, high: vec2f) -> f32 {
    return corner_solid_angle(high.x, high.y) - corner_solid_angle(low.x, high.y)
        - corner_solid_angle(high.x, low.y) + corner_solid_angle(low.x, low.y);
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= vec2u({{ resolution }}u)) { return; }
    let layer = id.z;
    let pick = (id.x * 5u + id.y * 3u) % {{ stride * stride }}u;
    let texel = id.xy * {{ stride }}u + vec2u(pick % {{ stride }}u, pick / {{ stride }}u);
    let index = (layer * {{ resolution }}u + id.y) * {{ resolution }}u + id.x;
    let triangle = textureLoad(shadow_ids, texel, layer, 0).x;
    if triangle == 0u {
        vpls[index] = Vpl(vec3f(0.0), 0u, vec3f(0.0), 0.0);
        return;
    }
    let view = views[layer + 1u];
    let light = lights[view.light];
    let scale = f32({{ stride }});
    let ray = view_ray(view, vec2f(texel) + 0.5);
    let to_right = Ray(scale * view.origin_dx, scale * view.direction_dx);
    let down = Ray(scale * view.origin_dy, scale * view.direction_dy);
    let hit = hit_triangle(triangle, ray, to_right, down);
    let material = materials[hit.material];
    let base_color = material_base_color(material, hit.uv, hit.uv_dx, hit.uv_dy).rgb;
    let metallic = material_roughness_metallic(material, hit.uv, hit.uv_dx, hit.uv_dy).y;
    let facing = select(1.0, -1.0, dot(hit.geometric_normal, ray.direction) > 0.0);

    // Light that this block of texels receives (lm or W); the axis has length 1, so its rim is half * size * |dx|.
    var received = light.color;
    if view.perspective == 1u {
        let half = 0.5 * view.size * length(view.direction_dx);
        let low = (vec2f(id.xy) / f32({{ resolution }}) * 2.0 - 1.0) * half;
        let high = (vec2f(id.xy + 1u) / f32({{ resolution }}) * 2.0 - 1.0) * half;
        received *= rectangle_solid_angle(low, high);
        if light.cone_slope > 0.0 { received *= spot_attenuation(light, -normalize(ray.direction)); }
    } else {
        received *= length(to_right.origin) * length(down.origin);
    }
    let albedo = base_color * (1.0 - metallic);
    vpls[index] = Vpl(hit.position, pack_unit_vector(facing * hit.normal), albedo * received, 0.0);
}
