// Surfels of what the camera sees: one pixel in the middle of each block, for the surface that the whole block shows.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/gbuffer.wgsl") }}
{{ use("techniques/lpv/surfel.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy * surfels.row + surfels.row / 2u;
    if any(pixel >= textureDimensions(depth_map)) { return; }
    let depth = textureLoad(depth_map, pixel, 0).x;
    if depth <= 0.0 { return; }
    let view = views[0];
    let ray = view_ray(view, vec2f(pixel) + 0.5);
    let normal = unpack_surface(textureLoad(surface_map, pixel, 0)).geometric_normal;
    // A block of pixels shows an area across the view's axis that grows with the square of the depth; on the surface it is
    // longer by the cosine between ray and axis over that between ray and normal (simulator/rsm.py, `vpl_area`).
    let across = select(cross(view.origin_dx, view.origin_dy),
                        depth * depth * cross(view.direction_dx, view.direction_dy), view.perspective == 1u);
    let secant = length(ray.direction);
    let footprint = f32(surfels.row * surfels.row) * length(across) / secant;
    let cosine = abs(dot(ray.direction, normal)) / secant;
    add_surfel(ray.origin + depth * ray.direction, normal, footprint / max(cosine, {{ min_cosine }}));
}
