// Lookup (CLPV 3.4): filtered light at each pixel's surface read as irradiance. The readings and the derivation of their
// factors: simulator/lpv/lookup.py.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/gbuffer.wgsl") }}
{{ use("shaders/sh.wgsl") }}
{{ use("techniques/lpv/storage_scale.wgsl") }}
{{ use("techniques/lpv/place.wgsl") }}
{{ use("techniques/lpv/texel.wgsl") }}

fn read_irradiance(c: vec4f, normal: vec3f) -> f32 {
    {% if reading == "dominant_lobe" %}
    let lobe = sh_dominant_lobe(c);
    let cosine = max(0.0, -dot(lobe.direction, normal));
    return lobe.flux * (lobe.fraction * cosine + (1.0 - lobe.fraction) * {{ 1 / 6 }});
    {% elif reading == "paper" %}
    return 4.0 * max(0.0, sh_evaluate(c, -normal));
    {% else %}
    return {{ scale }} * max(0.0, dot(c, sh_cosine_lobe(-normal)));
    {% endif %}
}

fn read_window(window: u32, seen: SeenPlace) -> vec3f {
    let place = place_in(window, seen);
    let at = texel_at(window, place);
    {% if damping %}
    let ahead = texel_at(window, place + 0.5 * seen.geometric_normal);
    let behind = texel_at(window, place - 0.5 * seen.geometric_normal);
    {% endif %}
    var irradiance = vec3f(0.0);
    {% for channel in ("red", "green", "blue") %}
    {
        let c = textureSampleLevel({{ channel }}, volume_sampler, at, 0.0);
        var kept = 1.0;
        {% if damping %}
        let gradient = textureSampleLevel({{ channel }}, volume_sampler, ahead, 0.0)
            - textureSampleLevel({{ channel }}, volume_sampler, behind, 0.0);
        let square = dot(c, c);
        kept = select(saturate(dot(c, c + gradient) / square), 1.0, square == 0.0);
        {% endif %}
        irradiance[{{ loop.index0 }}] = kept * read_irradiance(c, seen.normal);
    }
    {% endfor %}
    irradiance *= 1.0 / storage_scale(peak[0]);
    {% if reading != "thesis" %}
    irradiance *= 1.0 / (grids[window].cell_size * grids[window].cell_size);
    {% endif %}
    return irradiance;
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) pixel: vec3u) {
    if any(pixel.xy >= textureDimensions(depth_map)) { return; }
    let seen = seen_place(pixel.xy);
    if !seen.inside {
        textureStore(irradiance_out, pixel.xy, vec4f(0.0, 0.0, 0.0, 1.0));
        return;
    }
    {% if windows > 1 %}
    let reading = finest_reading(seen);
    let next = read_window(min(reading.window + 1u, {{ windows - 1 }}u), seen);
    let irradiance = mix(next, read_window(reading.window, seen), reading.share);
    {% else %}
    let irradiance = read_window(0u, seen);
    {% endif %}
    let visible = {{ "textureLoad(visibility_map, pixel.xy, 0).x" if visibility else "1.0" }};
    textureStore(irradiance_out, pixel.xy, vec4f(irradiance, visible));
}
