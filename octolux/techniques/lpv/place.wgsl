// Where a pixel's surface is looked up: in which window, and in its cells, moved along the normal.
{{ use("techniques/lpv/reading.wgsl") }}

struct SeenPlace { inside: bool, surface: vec3f, geometric_normal: vec3f, normal: vec3f }

fn seen_place(pixel: vec2u) -> SeenPlace {
    let depth = textureLoad(depth_map, pixel, 0).x;
    let ray = view_ray(views[0], vec2f(pixel) + 0.5);
    let s = unpack_surface(textureLoad(surface_map, pixel, 0));
    let surface = ray.origin + depth * ray.direction;
    return SeenPlace(depth > 0.0 && held_at_all(surface), surface, s.geometric_normal, s.normal);
}

fn place_in(window: u32, seen: SeenPlace) -> vec3f {
    return place_at(window, seen.surface, {{ lookup_offset }} * seen.geometric_normal);
}

fn finest_reading(seen: SeenPlace) -> Reading {
    return reading_at(seen.surface, {{ lookup_offset }} * seen.geometric_normal);
}
