// Composite = (emissive + direct + diffuse albedo / pi * irradiance * ambient visibility + specular) * transmittance + fog; the mean over the samples
// of a pixel; then exposure, tone map and sRGB for display (references: simulator/tonemap.py).
{{ use("shaders/view.wgsl") }}
{{ use("shaders/brdf.wgsl") }}
{{ use("shaders/tonemap.wgsl") }}
{{ use("shaders/environment.wgsl") }}

// Radiance, and 1 where a surface is seen.
{% if given %}
fn seen(pixel: vec2u) -> vec4f { return textureLoad(given_map, pixel, 0); }
{% else %}
fn seen(pixel: vec2u) -> vec4f {
    if textureLoad(depth_map, pixel, 0).x <= 0.0 {
        {% if transparent %}
        return vec4f(0.0);
        {% elif even_surroundings %}
        return vec4f(environment.radiance, 0.0);
        {% else %}
        return vec4f(environment_radiance(normalize(view_ray(views[0], vec2f(pixel) + 0.5).direction)), 0.0);
        {% endif %}
    }
    let s = unpack_surface(textureLoad(surface_map, pixel, 0));
    var radiance = textureLoad(direct_map, pixel, 0).rgb;
    {% if emissive %}
    let emissive = textureLoad(emissive_map, pixel, 0);
    radiance += emissive.rgb * select(1.0, 1.0 / settings.exposure, emissive.a > 0.0);
    {% endif %}
    {% if irradiance %}
    let irradiance = textureLoad(irradiance_map, pixel, 0);
    radiance += diffuse_albedo(s) / {{ pi }} * irradiance.rgb * irradiance.a;
    {% endif %}
    {% if specular %}
    radiance += textureLoad(specular_map, pixel, 0).rgb;
    {% endif %}
    return vec4f(radiance, 1.0);
}
{% endif %}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) pixel: vec3u) {
    if any(pixel.xy >= textureDimensions(depth_map)) { return; }
    {% if fog %}
    let clear = seen(pixel.xy);
    let passed = textureLoad(transmittance_map, pixel.xy, 0).rgb;
    let scattered = textureLoad(fog_map, pixel.xy, 0).rgb;
    // What of the surroundings the medium hides it covers as a surface does.
    let covered = 1.0 - (1.0 - clear.a) * dot(passed, vec3f({{ 1 / 3 }}));
    var mean = settings.weight * vec4f(clear.rgb * passed + scattered, covered);
    {% else %}
    var mean = settings.weight * seen(pixel.xy);
    {% endif %}
    {% if not first %}
    mean += textureLoad(radiance_so_far, pixel.xy, 0);
    {% endif %}
    textureStore(radiance_out, pixel.xy, mean);
    {% if last %}
    let exposed = max(mean.rgb * settings.exposure, vec3f(0.0));
    textureStore(display_out, pixel.xy, vec4f(srgb_encode({{ tone_map }}(exposed)), 1.0));
    {% endif %}
}
