// Glossy reflections of what the camera sees: light out of the reflected direction, times the specular lobe's albedo.
// At a share of the resolution only the light, the lobe's direction and the depth that they belong to are kept.
{{ use("shaders/view.wgsl") }}
{{ use("techniques/lpv/storage_scale.wgsl") }}
{{ use("shaders/reflection.wgsl") }}
{{ use("techniques/lpv/place.wgsl") }}
{{ use("techniques/lpv/glossy/%s.wgsl" % march) }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(light_out)) { return; }
    {% if resolution > 1 %}
    let pixel = min({{ resolution }}u * id.xy + {{ resolution // 2 }}u, textureDimensions(depth_map) - 1u);
    {% else %}
    let pixel = id.xy;
    {% endif %}
    let seen = seen_place(pixel);
    let s = unpack_surface(textureLoad(surface_map, pixel, 0));
    let to_eye = -normalize(view_ray(views[0], vec2f(pixel) + 0.5).direction);
    let albedo = lobe_albedo(s, to_eye);
    let wanted = seen.inside && any(albedo > vec3f({{ darkest }}));
    let towards = reflected_direction(s, to_eye);
    let base = finest_reading(seen).window;
    let grid = grids[0];
    let at = (seen.surface - grid.origin) / grid.cell_size + {% if windows > 1 %}vec3f(windows[0].origin){% else %}vec3f(0.0){% endif %};
    let clear = at + {{ lookup_offset }} * f32(1u << base) * s.geometric_normal;
    let light = incident(clear, towards, base, {{ cone }} * alpha_of(s), wanted)
        / (storage_scale(peak[0]) * grid.cell_size * grid.cell_size);
    {% if resolution > 1 %}
    textureStore(light_out, id.xy, vec4f(light, select(0.0, textureLoad(depth_map, pixel, 0).x, wanted)));
    {% else %}
    textureStore(light_out, id.xy, vec4f(albedo * light, 1.0));
    {% endif %}
}
