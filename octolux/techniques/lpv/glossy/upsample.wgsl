// Light of every pixel from that of a share of them: of the four around it those that are as far away (joint bilateral
// upsampling, Kopf et al. 2007), times the pixel's own albedo of the specular lobe.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/reflection.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) pixel: vec3u) {
    if any(pixel.xy >= textureDimensions(depth_map)) { return; }
    let s = unpack_surface(textureLoad(surface_map, pixel.xy, 0));
    let to_eye = -normalize(view_ray(views[0], vec2f(pixel.xy) + 0.5).direction);
    let depth = textureLoad(depth_map, pixel.xy, 0).x;
    let last = vec2i(textureDimensions(light_map)) - 1;
    let place = (vec2f(pixel.xy) - {{ resolution // 2 }}.0) / {{ resolution }}.0;
    let low = floor(place);
    let part = place - low;
    var found = vec4f(0.0);
    {% for y in range(2) %}
    {% for x in range(2) %}
    {
        let other = textureLoad(light_map, clamp(vec2i(low) + vec2i({{ x }}, {{ y }}), vec2i(0), last), 0);
        let near = {{ "part.x" if x else "(1.0 - part.x)" }} * {{ "part.y" if y else "(1.0 - part.y)" }} + {{ least_near }};
        let apart = (other.a - depth) / ({{ apart }} * depth);
        found += select(0.0, near * exp(-min(apart * apart, 80.0)), other.a > 0.0) * vec4f(other.rgb, 1.0);
    }
    {% endfor %}
    {% endfor %}
    let light = select(vec3f(0.0), found.rgb / max(found.a, 1e-30), depth > 0.0 && found.a > 0.0);
    textureStore(specular_out, pixel.xy, vec4f(lobe_albedo(s, to_eye) * light, 1.0));
}
