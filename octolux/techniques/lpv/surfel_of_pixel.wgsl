// Surfels of what the camera sees: one pixel in the middle of each block, for the surface that the whole block shows.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/gbuffer.wgsl") }}

fn surfel_pixel(number: u32) -> vec2u {
    return vec2u(number % surfels.width, number / surfels.width) * surfels.block + surfels.block / 2u;
}

fn surfel_at(number: u32) -> Surfel {
    let pixel = surfel_pixel(number);
    let depth = textureLoad(depth_map, pixel, 0).x; // 0 outside the picture
    let view = views[0];
    let ray = view_ray(view, vec2f(pixel) + 0.5);
    let normal = unpack_surface(textureLoad(surface_map, pixel, 0)).geometric_normal;
    // A block of pixels shows an area across the view's axis that grows with the square of the depth; on the surface it is
    // longer by the cosine between ray and axis over that between ray and normal (simulator/rsm.py, `vpl_area`).
    let across = select(cross(view.origin_dx, view.origin_dy),
                        depth * depth * cross(view.direction_dx, view.direction_dy), view.perspective == 1u);
    let secant = length(ray.direction);
    let footprint = f32(surfels.block * surfels.block) * length(across) / secant;
    let cosine = abs(dot(ray.direction, normal)) / secant;
    let area = footprint / max(cosine, {{ min_cosine }});
    let seen = depth > 0.0 && all(pixel < textureDimensions(depth_map));
    return Surfel(ray.origin + depth * ray.direction, normal, select(0.0, area, seen));
}
