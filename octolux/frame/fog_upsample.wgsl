// Fog of every pixel: joint bilateral upsampling (Kopf et al. 2007) of the mean fluence by the length of the path; what the
// path's own length and the medium say is worked out anew, so that silhouettes stay sharp. Radiance is
// albedo / (4 pi) * fluence * (1 - T), a step of Hillaire 2015, (S - S e^(-x)) / extinction, for the path as a whole.
{{ use("frame/fog_path.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) pixel: vec3u) {
    if any(pixel.xy >= textureDimensions(depth_map)) { return; }
    let path = path_of(pixel.xy);
    {% if resolution == 1 %}
    var found = vec4f(textureLoad(fluence_map, pixel.xy, 0).rgb, 1.0);
    {% if density %}
    var density = textureLoad(fog_density, pixel.xy, 0).x;
    {% endif %}
    {% else %}
    let last = vec2i(textureDimensions(fluence_map)) - 1;
    let place = (vec2f(pixel.xy) + 0.5) / {{ resolution }}.0 - 0.5;
    let low = floor(place);
    let part = place - low;
    var found = vec4f(0.0);
    {% if density %}
    var density = 0.0;
    {% endif %}
    {% for y in range(2) %}
    {% for x in range(2) %}
    {
        let texel = clamp(vec2i(low) + vec2i({{ x }}, {{ y }}), vec2i(0), last);
        let other = textureLoad(fluence_map, texel, 0);
        let near = {{ "part.x" if x else "(1.0 - part.x)" }} * {{ "part.y" if y else "(1.0 - part.y)" }};
        let weight = near * alike(path.length, other.a);
        found += weight * vec4f(other.rgb, 1.0);
        {% if density %}
        density += weight * textureLoad(fog_density, texel, 0).x;
        {% endif %}
    }
    {% endfor %}
    {% endfor %}
    {% endif %}
    {% if density %}
    let x = medium.extinction * (path.length * density / found.a);
    {% else %}
    let x = medium.extinction * path.length;
    {% endif %}
    let radiance = medium.albedo * {{ 1 / (4 * pi) }} * (found.rgb / found.a) * absorbed(x);
    textureStore(inscattered_out, pixel.xy, vec4f(radiance, 1.0));
    textureStore(transmittance_out, pixel.xy, vec4f(exp(-x), 1.0));
}
