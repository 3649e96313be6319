// Where a pixel's surface is looked up, in cells.
struct SeenPlace { inside: bool, place: vec3f, normal: vec3f }

fn seen_place(pixel: vec2u) -> SeenPlace {
    let depth = textureLoad(depth_map, pixel, 0).x;
    let ray = view_ray(views[0], vec2f(pixel) + 0.5);
    let s = unpack_surface(textureLoad(surface_map, pixel, 0));
    let surface = (ray.origin + depth * ray.direction - grid.origin) / grid.cell_size;
    let inside = depth > 0.0 && all(surface >= vec3f(0.0)) && all(surface <= vec3f({{ n }}.0));
    return SeenPlace(inside, surface + {{ lookup_offset }} * s.geometric_normal, s.normal);
}
