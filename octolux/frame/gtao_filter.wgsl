// Mean of 4 x 4 neighbours in the same surface: each sample of the noise's tile once, wherever the window lies. A neighbour
// counts less the farther it lies from the pixel's tangent plane, and hardly at all from the width of a pixel of the raw
// picture on, at this depth. So slanted planes are filtered whole, and what stands before or behind is not mixed in, at any
// scale. At half resolution this also fills in the pixels between.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/gbuffer.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(depth_map);
    if any(id.xy >= size) { return; }
    let pixel = vec2i(id.xy);
    let depth = textureLoad(depth_map, pixel).x;
    let view = views[0];
    let ray = view_ray(view, vec2f(pixel) + 0.5);
    let normal = unpack_surface(textureLoad(surface_map, pixel)).geometric_normal;
    let raw_size = textureDimensions(raw_map);
    let width = {{ resolution }}.0 * length(view.origin_dx + depth * view.direction_dx);
    let ahead = dot(ray.direction, normal) / width;
    let first = (pixel + {{ 2 if resolution == 1 else 1 }}) / {{ resolution }} - {{ 4 if resolution == 1 else 2 }};
    var sum = vec2f(0.0);
    {% for y in range(4) %}{% for x in range(4) %}
    {
        let at = first + vec2i({{ x }}, {{ y }});
        let raw = textureLoad(raw_map, at).xy;
        let there = min({{ resolution }} * at + {{ resolution // 2 }}, vec2i(size) - 1);
        let moved = vec2f(there - pixel);
        let height = (raw.y - depth) * ahead + dot(normal, between_rays(view, moved, raw.y)) / width;
        let near = max(1.0 - abs(height), {{ least_weight }});
        sum += select(vec2f(0.0), near * vec2f(raw.x, 1.0), raw.y > 0.0 && all(vec2u(at) < raw_size));
    }
    {% endfor %}{% endfor %}
    let seen = select(1.0, sum.x / sum.y, depth > 0.0 && sum.y > 0.0);
    textureStore(visibility_out, id.xy, vec4f(seen));
}
