// G-buffer: leads each pixel's triangle back to its surface. depth is along the camera's axis; 0 where nothing is seen.
{{ use("shaders/surface.wgsl") }}
{{ use("shaders/gbuffer.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) pixel: vec3u) {
    if any(pixel.xy >= textureDimensions(visibility)) { return; }
    let id = textureLoad(visibility, pixel.xy, 0).x;
    if id == 0u {
        textureStore(surface_out, pixel.xy, vec4u(0u));
        textureStore(depth_out, pixel.xy, vec4f(0.0));
        {% if emissive %}
        textureStore(emissive_out, pixel.xy, vec4f(0.0));
        {% endif %}
        return;
    }
    let view = views[0];
    let to_right = Ray(view.origin_dx, view.direction_dx);
    let down = Ray(view.origin_dy, view.direction_dy);
    let ray = view_ray(view, vec2f(pixel.xy) + 0.5);
    let hit = hit_triangle(id, ray, to_right, down);
    let material = load_materials(hit.material);
    // Both sides of a surface reflect; the normal is that of the side we see.
    let facing = select(1.0, -1.0, dot(hit.geometric_normal, ray.direction) > 0.0);
    let roughness_metallic = material_roughness_metallic(material, hit.uv, hit.footprint);
    var reflected = base_color(hit, material).rgb;
    var specular = material.specular;
    {% if unlit %}
    let shown = reflected;
    if material.unlit == 1u {
        reflected = vec3f(0.0);
        specular = 0.0;
    }
    {% endif %}
    let surface = Surface(
        facing * mapped_normal(hit, material),
        facing * hit.geometric_normal,
        reflected, roughness_metallic.x, roughness_metallic.y, specular,
    );
    textureStore(surface_out, pixel.xy, pack_surface(surface));
    textureStore(depth_out, pixel.xy, vec4f(hit.depth));
    {% if emissive %}
    // Alpha 1 is for what is shown as it is, whatever the exposure.
    var emitted = vec4f(material_emissive(material, hit.uv, hit.footprint), 0.0);
    {% if unlit %}
    if material.unlit == 1u { emitted = vec4f(shown, 1.0); }
    {% endif %}
    textureStore(emissive_out, pixel.xy, emitted);
    {% endif %}
}
