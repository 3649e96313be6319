// Takes the pattern of the ordered dither out of fog: of 5 x 5 texels the outer ones count half, so that each of the 16
// places of the pattern counts as much as any other; those whose paths differ in length hardly count.
{{ use("frame/fog_path.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(fluence_map)) { return; }
    let last = vec2i(textureDimensions(fluence_map)) - 1;
    let own = textureLoad(fluence_map, id.xy, 0);
    var sum = vec4f(0.0);
    {% if density %}
    var depth = 0.0;
    {% endif %}
    {% for y in range(-2, 3) %}
    {% for x in range(-2, 3) %}
    {
        let texel = clamp(vec2i(id.xy) + vec2i({{ x }}, {{ y }}), vec2i(0), last);
        let other = textureLoad(fluence_map, texel, 0);
        let weight = {{ (0.5 if x in (-2, 2) else 1.0) * (0.5 if y in (-2, 2) else 1.0) }} * alike(own.a, other.a);
        sum += weight * vec4f(other.rgb, 1.0);
        {% if density %}
        depth += weight * textureLoad(fog_density, texel, 0).x;
        {% endif %}
    }
    {% endfor %}
    {% endfor %}
    textureStore(fluence_out, id.xy, vec4f(sum.rgb / sum.a, own.a));
    {% if density %}
    textureStore(density_out, id.xy, vec4f(depth / sum.a));
    {% endif %}
}
