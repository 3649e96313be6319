// Lookup (CLPV 3.4): filtered light at each pixel's surface read as irradiance. The readings and the derivation of their
// factors: simulator/lpv/lookup.py.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/gbuffer.wgsl") }}
{{ use("shaders/sh.wgsl") }}
{{ use("techniques/lpv/storage_scale.wgsl") }}

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

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) pixel: vec3u) {
    if any(pixel.xy >= textureDimensions(depth_map)) { return; }
    let depth = textureLoad(depth_map, pixel.xy, 0).x;
    let ray = view_ray(views[0], vec2f(pixel.xy) + 0.5);
    let s = unpack_surface(textureLoad(surface_map, pixel.xy, 0));
    let extent = grid.cell_size * f32(grid.n);
    let surface = (ray.origin + depth * ray.direction - grid.origin) / extent;
    if depth <= 0.0 || any(surface < vec3f(0.0)) || any(surface > vec3f(1.0)) {
        textureStore(irradiance_out, pixel.xy, vec4f(0.0, 0.0, 0.0, 1.0));
        return;
    }
    let cell = 1.0 / f32(grid.n);
    let place = surface + s.geometric_normal * ({{ lookup_offset }} * cell);
    var irradiance = vec3f(0.0);
    {% for channel in ("red", "green", "blue") %}
    {
        let c = textureSampleLevel({{ channel }}, volume_sampler, place, 0.0);
        var kept = 1.0;
        {% if damping %}
        let half_cell = s.geometric_normal * (0.5 * cell);
        let gradient = textureSampleLevel({{ channel }}, volume_sampler, place + half_cell, 0.0)
            - textureSampleLevel({{ channel }}, volume_sampler, place - half_cell, 0.0);
        let square = dot(c, c);
        kept = select(saturate(dot(c, c + gradient) / square), 1.0, square == 0.0);
        {% endif %}
        irradiance[{{ loop.index0 }}] = kept * read_irradiance(c, s.normal);
    }
    {% endfor %}
    irradiance *= 1.0 / storage_scale(peak[0]);
    {% if reading != "thesis" %}
    irradiance *= 1.0 / (grid.cell_size * grid.cell_size);
    {% endif %}
    textureStore(irradiance_out, pixel.xy, vec4f(irradiance, 1.0));
}
