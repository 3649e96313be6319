// Direct light of the sky, of area lights and of every directional, spot and point light, with shadows: outgoing radiance
// towards the camera{% if diffuse %}, and of that what the diffuse lobe reflects{% endif %}.
// A few lights are unrolled: with constant indices a software adapter reads lights and views once for all pixels.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/brdf.wgsl") }}
{{ use("shaders/lights.wgsl") }}
{% if medium %}
{{ use("shaders/medium.wgsl") }}
{% endif %}

struct Point { position: vec3f, to_eye: vec3f, surface: Surface }

// Radiance under light from unit direction l that brings `illuminance`, of which `lit` arrives.
fn reflected(p: Point, l: vec3f, illuminance: vec3f, lit: f32) -> TwoLobes {
    let facing = select(0.0, max(dot(p.surface.normal, l), 0.0), dot(p.surface.geometric_normal, l) > 0.0);
    return times(brdf_lobes(p.surface, l, p.to_eye), illuminance * (facing * lit));
}

fn from_directional(p: Point, index: u32, view: u32) -> TwoLobes {
    let light = lights[index];
    let lit = lit_fraction(view, p.position, p.surface.geometric_normal, light.texel);
    return reflected(p, -light.direction, directional_illuminance(light), lit);
}

fn from_spot(p: Point, index: u32, view: u32) -> TwoLobes {
    let light = lights[index];
    let to_light = light.position - p.position;
    let l = normalize(to_light);
    let footprint = light.texel * -dot(to_light, light.direction);
    let lit = lit_fraction(view, p.position, p.surface.geometric_normal, footprint) * spot_attenuation(light, l);
    return reflected(p, l, point_illuminance(light, to_light), lit);
}

fn from_point(p: Point, index: u32, first_view: u32) -> TwoLobes {
    let light = lights[index];
    let to_light = light.position - p.position;
    let a = abs(to_light);
    let footprint = light.texel * max(a.x, max(a.y, a.z));
    let lit = lit_fraction(first_view + cube_face(-to_light), p.position, p.surface.geometric_normal, footprint);
    return reflected(p, normalize(to_light), point_illuminance(light, to_light), lit);
}

{% if emitters %}
fn emitter_fraction(p: Point, light: Light, to_light: vec3f, first_view: u32) -> f32 {
    let a = abs(to_light);
    let footprint = light.texel * max(a.x, max(a.y, a.z));
    return coarse_fraction(first_view + cube_face(-to_light), p.position, p.surface.geometric_normal, footprint);
}

fn from_emitter(p: Point, index: u32, first_view: u32) -> TwoLobes {
    let light = lights[index];
    let to_light = light.position - p.position;
    let lit = emitter_fraction(p, light, to_light, first_view);
    return reflected(p, normalize(to_light), emitter_illuminance(light, to_light), lit);
}
{% endif %}

{% if areas %}
{{ use("shaders/ltc.wgsl") }}

// What an emitter that stands for an area light would bring, and what of it arrives; number is its own among the emitters.
fn emitter_share(p: Point, number: u32) -> vec2f {
    let light = lights[{{ emitter_light }}u + number];
    let to_light = light.position - p.position;
    let l = normalize(to_light);
    let share = dot(emitter_illuminance(light, to_light), vec3f(1.0)) * max(dot(p.surface.normal, l), 0.0);
    var lit = emitter_fraction(p, light, to_light, {{ coarse_view }}u + {{ cube_faces }}u * number);
    {% if medium %}
    lit *= dot(through_from_place(light, p.position), vec3f({{ 1 / 3 }})); // of several emitters one number is made
    {% endif %}
    return share * vec2f(1.0, select(0.0, lit, dot(p.surface.geometric_normal, l) > 0.0));
}

// The ratio estimator (frame/area_lights.py). Where all emitters are below the horizon and a part of the light is not,
// nothing is known of its shadow, and it is taken to arrive: little light, from where the surface would hide it first.
fn from_area(p: Point, lobe: Lobe, number: u32, share: vec2f) -> TwoLobes {
    let lit = select(share.y / share.x, 1.0, share.x <= 0.0);
    return times(area_light_radiance(area_lights[number], p.position, p.to_eye, p.surface, lobe), vec3f(lit));
}
{% endif %}

{% if sky %}
{{ use("shaders/environment.wgsl") }}

// The sky: its irradiance and its reflection, times what arrives of it past the scene. A few distant lights that stand for it
// and have shadow maps say that: of the irradiance each is a share; of the lobe around the mirrored direction, a von
// Mises-Fisher lobe of the GGX lobe's sharpness (Wang et al. 2009, 3.2), but none narrower than the share of one light.
// Where pixels have many samples each of these asks some of the lights, and all samples of a pixel together ask all.
fn from_sky(p: Point, pixel: vec2u) -> TwoLobes {
    let s = p.surface;
    let n_v = max(dot(s.normal, p.to_eye), 0.0);
    let mirrored = reflect(-p.to_eye, s.normal);
    let roughness = max(s.roughness, {{ min_roughness }});
    let alpha = roughness * roughness;
    let sharpness = min(0.5 / (alpha * alpha * max(n_v, 0.05)), {{ 0.5 * sky }});
    var all = vec3f(0.0);
    var arrived = vec3f(0.0);
    var lobe = vec2f(0.0);
    let first = (sky_pick.sample + pixel.x + 2u * pixel.y) % sky_pick.step;
    for (var i = {{ sky_first }}u + first; i < {{ sky_first + sky }}u; i += sky_pick.step) {
        let light = lights[i];
        let l = -light.direction;
        // What comes from below the surface is no loss to the lobe: its directional albedo has it already.
        var above = 0.0;
        var lit = 0.0;
        if dot(s.geometric_normal, l) > 0.0 {
            above = 1.0;
            lit = coarse_fraction({{ sky_view - sky_first }}u + i, p.position, s.geometric_normal, light.texel);
        }
        let share = light.color * max(dot(s.normal, l), 0.0);
        all += share;
        {% if medium %}
        let passed = through_from_afar(light, p.position);
        arrived += lit * passed * share;
        lit *= dot(passed, vec3f({{ 1 / 3 }})); // of the reflection: its colour is the lobe's
        {% else %}
        arrived += lit * share;
        {% endif %}
        // Held at -80, where float32 still has an exponential: with many lights the lobe is narrow.
        lobe += exp(max(sharpness * (dot(mirrored, l) - 1.0), -80.0)) * vec2f(above, lit);
    }
    let irradiance = environment_irradiance_at(s.normal) * arrived / max(all, vec3f(1e-20));
    let even = even_reflection(roughness, n_v);
    let f0 = mix(vec3f({{ dielectric_f0 }} * s.specular), s.base_color, s.metallic);
    let f90 = s.specular * (1.0 - s.metallic) + s.metallic;
    let reflected = environment_lobe(mirrored, alpha) * (lobe.y / max(lobe.x, 1e-37));
    let kept = 1.0 - mix(f0, vec3f(f90), even.z);
    return TwoLobes(kept * diffuse_albedo(s) / {{ pi }} * irradiance, (f0 * even.x + f90 * even.y) * reflected);
}
{% endif %}

{# What the medium leaves of a light's way to the surface. #}
{% macro passed(kind, index) %}{% if medium %}through_from_{{ "afar" if kind == "directional" else "place" }}(lights[{{ index }}], p.position){% else %}vec3f(1.0){% endif %}{% endmacro %}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) pixel: vec3u) {
    if any(pixel.xy >= textureDimensions(depth_map)) { return; }
    let depth = textureLoad(depth_map, pixel.xy, 0).x;
    if depth <= 0.0 {
        textureStore(direct_out, pixel.xy, vec4f(0.0));
        {% if diffuse %}textureStore(diffuse_out, pixel.xy, vec4f(0.0));{% endif %}
        return;
    }
    let ray = view_ray(views[0], vec2f(pixel.xy) + 0.5);
    let surface = unpack_surface(textureLoad(surface_map, pixel.xy, 0));
    let p = Point(ray.origin + depth * ray.direction, -normalize(ray.direction), surface);
    var radiance = TwoLobes(vec3f(0.0), vec3f(0.0));
    {% if sky %}
    radiance = plus(radiance, from_sky(p, pixel.xy));
    {% endif %}
    {% for kind, first, count, first_view, views_each in groups %}
    {% if unrolled %}
    {% for i in range(count) %}
    radiance = plus(radiance, times(from_{{ kind }}(p, {{ first + i }}u, {{ first_view + i * views_each }}u), {{ passed(kind, "%du" % (first + i)) }}));
    {% endfor %}
    {% elif count %}
    for (var i = 0u; i < {{ count }}u; i++) {
        radiance = plus(radiance, times(from_{{ kind }}(p, {{ first }}u + i, {{ first_view }}u + i * {{ views_each }}u), {{ passed(kind, "%du + i" % first) }}));
    }
    {% endif %}
    {% endfor %}
    {% if areas %}
    let lobe = specular_lobe(surface, p.to_eye);
    {% if unrolled %}
    {% for first, count in areas %}
    let share{{ loop.index0 }} = {% for i in range(count) %}{{ " + " if i }}emitter_share(p, {{ first + i }}u){% endfor %};
    radiance = plus(radiance, from_area(p, lobe, {{ loop.index0 }}u, share{{ loop.index0 }}));
    {% endfor %}
    {% else %}
    for (var i = 0u; i < {{ areas | length }}u; i++) {
        var share = vec2f(0.0);
        for (var k = 0u; k < area_lights[i].emitters; k++) { share += emitter_share(p, area_lights[i].first + k); }
        radiance = plus(radiance, from_area(p, lobe, i, share));
    }
    {% endif %}
    {% endif %}
    textureStore(direct_out, pixel.xy, vec4f(radiance.diffuse + radiance.specular, 1.0));
    {% if diffuse %}textureStore(diffuse_out, pixel.xy, vec4f(radiance.diffuse, 1.0));{% endif %}
}
