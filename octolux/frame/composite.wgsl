// Composite = emissive + direct + diffuse albedo / pi * irradiance * ambient visibility + specular; then exposure, the
// Khronos PBR neutral tone map and sRGB for display (references: simulator/tonemap.py).
{{ use("shaders/brdf.wgsl") }}
{{ use("shaders/tonemap.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) pixel: vec3u) {
    if any(pixel.xy >= textureDimensions(depth_map)) { return; }
    var radiance = settings.background;
    if textureLoad(depth_map, pixel.xy, 0).x > 0.0 {
        let s = unpack_surface(textureLoad(surface_map, pixel.xy, 0));
        radiance = textureLoad(direct_map, pixel.xy, 0).rgb;
        {% if emissive %}
        radiance += textureLoad(emissive_map, pixel.xy, 0).rgb;
        {% endif %}
        {% if irradiance %}
        let irradiance = textureLoad(irradiance_map, pixel.xy, 0);
        radiance += diffuse_albedo(s) / {{ pi }} * irradiance.rgb * irradiance.a;
        {% endif %}
        {% if specular %}
        radiance += textureLoad(specular_map, pixel.xy, 0).rgb;
        {% endif %}
    }
    textureStore(radiance_out, pixel.xy, vec4f(radiance, 1.0));
    textureStore(display_out, pixel.xy, vec4f(srgb_encode(neutral_tone_map(radiance * settings.exposure)), 1.0));
}
