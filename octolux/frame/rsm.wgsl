// Reflective shadow maps: one VPL per {{ stride }} x {{ stride }} shadow-map texels, led back to its surface from the
// triangle number that the shadow map's own rendering wrote. Which texel of a block is taken follows a lattice, so that
// the texels of any {{ stride }} x {{ stride }} neighbouring blocks are all different and on average lie in the block's middle.
{{ use("shaders/surface.wgsl") }}
{{ use("shaders/lights.wgsl") }}
{% if medium %}
{{ use("shaders/medium.wgsl") }}
{% endif %}
{% if surfaces %}
{{ use("shaders/traits.wgsl") }}
{% endif %}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= vec2u({{ resolution }}u)) { return; }
    let layer = id.z;
    let pick = (id.x * {{ stride + 1 }}u + id.y * {{ stride }}u) % {{ stride * stride }}u;
    let texel = id.xy * {{ stride }}u + vec2u(pick % {{ stride }}u, pick / {{ stride }}u);
    let index = maps.first_vpl + (layer * {{ resolution }}u + id.y) * {{ resolution }}u + id.x;
    let triangle = textureLoad(shadow_ids, texel, layer, 0).x;
    if triangle == 0u {
        store_vpls(index, Vpl(vec3f(0.0), 0u, vec3f(0.0), 0.0));
        {% if surfaces %}
        store_surfaces(index, 0u);
        {% endif %}
        return;
    }
    let view = views[maps.first_view + layer];
    let light = lights[view.light];
    let scale = f32({{ stride }});
    let ray = view_ray(view, vec2f(texel) + 0.5);
    let to_right = Ray(scale * view.origin_dx, scale * view.direction_dx);
    let down = Ray(scale * view.origin_dy, scale * view.direction_dy);
    let hit = hit_triangle(triangle, ray, to_right, down);
    let material = load_materials(hit.material);
    var reflected = base_color(hit, material).rgb;
    {% if unlit %}
    if material.unlit == 1u { reflected = vec3f(0.0); }
    {% endif %}
    let metallic = material_roughness_metallic(material, hit.uv, hit.footprint).y;
    let along = dot(hit.geometric_normal, ray.direction);
    let facing = select(1.0, -1.0, along > 0.0);

    // Light that this block of texels receives (lm or W). Its solid angle is area * cos^3 at distance 1 (OLPV 3.3), where
    // the ray, whose part along the axis is 1, has the length 1 / cos. The exact difference of arctangents would lose more
    // to rounding than this midpoint rule errs, 1e-5 at 256 texels.
    // footprint: what the block covers at the surface's distance, across the ray (m^2).
    var received = light.color;
    var footprint = length(to_right.origin) * length(down.origin);
    let secant = length(ray.direction);
    if view.perspective == 1u {
        let solid_angle = length(to_right.direction) * length(down.direction) / (secant * secant * secant);
        footprint = solid_angle * pow(hit.depth * secant, 2.0);
        {% if inverse_square %}
        received *= solid_angle;
        {% else %}
        received *= select(footprint, solid_angle, maps.emitters == 1u);
        {% endif %}
        if maps.emitters == 1u {
            received *= emitter_lobe(light, normalize(ray.direction));
        } else if light.cone_slope > 0.0 {
            received *= spot_attenuation(light, -normalize(ray.direction));
        }
    } else {
        received *= footprint;
    }
    {% if medium %}
    if view.perspective == 1u {
        received *= through_from_place(light, hit.position);
    } else {
        received *= through_from_afar(light, hit.position);
    }
    {% endif %}
    let albedo = reflected * (1.0 - metallic);
    let area = footprint / max(abs(along) / secant, {{ min_cosine }});
    store_vpls(index, Vpl(hit.position, pack_unit_vector(facing * hit.normal), albedo * received, area));
    {% if surfaces %}
    store_surfaces(index, pack_traits(albedo, load_instances(load_items((triangle - 1u) >> CLUSTER_BITS).instance)));
    {% endif %}
}
