// Irradiance of every pixel from that of pixels around it, of which each tile of {{ tile }} x {{ tile }} has all phases of directions
// once: the mean, over a tent twice as wide, of those that are alike (simulator/voxels/filtering.py). At a share of the
// resolution this also fills in the pixels between.
{{ use("techniques/voxel_cones/cones/alike.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(depth_map)) { return; }
    let own = pixel_plane(vec2i(id.xy));
    let first = (own.pixel + {{ resolution - resolution // 2 }}) / {{ resolution }} - {{ tile }};
    let size = textureDimensions(light_map);
    var sum = vec4f(0.0);
    var weights = 0.0;
    {% set taps = 2 * tile - (resolution == 1) %}{# else the tent is 0 at the last #}
    {% for y in range(taps) %}{% for x in range(taps) %}
    {
        let at = first + vec2i({{ x }}, {{ y }});
        let away = abs(vec2f({{ resolution }} * at + {{ resolution // 2 }} - own.pixel)) * {{ 1 / (tile * resolution) }};
        let tent = max(vec2f(0.0), 1.0 - away);
        let weight = tent.x * tent.y * select(0.0, alike(own, at, textureLoad(place_map, at)), all(vec2u(at) < size));
        sum += weight * textureLoad(light_map, at);
        weights += weight;
    }
    {% endfor %}{% endfor %}
    let mean = select(vec4f(0.0, 0.0, 0.0, 1.0), sum / max(weights, 1e-20), own.depth > 0.0 && weights > 0.0);
    textureStore(irradiance_out, id.xy, vec4f(mean.rgb, 1.0));
    textureStore(visibility_out, id.xy, vec4f(mean.a));
}
