// Reflections of every pixel from those of a share of them: of the four around it, those in its tangent plane that look the
// same way (see filter.wgsl), times the pixel's own albedo of the specular lobe. A mean of more would blur mirrors.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/reflection.wgsl") }}
{{ use("techniques/voxel_cones/cones/alike.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(depth_map)) { return; }
    let pixel = vec2i(id.xy);
    let own = pixel_plane(pixel);
    let last = vec2i(textureDimensions(light_map)) - 1;
    let place = (vec2f(pixel) - {{ resolution // 2 }}.0) / {{ resolution }}.0;
    let low = floor(place);
    let part = place - low;
    var found = vec4f(0.0);
    {% for y in range(2) %}{% for x in range(2) %}
    {
        let at = clamp(vec2i(low) + vec2i({{ x }}, {{ y }}), vec2i(0), last);
        let near = {{ "part.x" if x else "(1.0 - part.x)" }} * {{ "part.y" if y else "(1.0 - part.y)" }} + {{ least_weight }};
        found += near * alike(own, at, textureLoad(place_map, at)) * vec4f(textureLoad(light_map, at).rgb, 1.0);
    }
    {% endfor %}{% endfor %}
    let to_eye = -normalize(view_ray(views[0], vec2f(pixel) + 0.5).direction);
    let light = select(vec3f(0.0), found.rgb / max(found.a, 1e-30), own.depth > 0.0 && found.a > 0.0);
    textureStore(specular_out, id.xy, vec4f(lobe_albedo(own.surface, to_eye) * light, 1.0));
}
