// What is seen by a pixel of a picture of each {{ resolution }}th row and column, and where its cones start.
{% if sky %}{{ use("shaders/environment.wgsl") }}{% endif %}

// there: a surface inside the cube.  place: voxels of level 0; start: off the surface.  depth: 0 where nothing is seen.
struct SeenVoxel {
    pixel: vec2u, place: vec3f, start: vec3f, normal: vec3f, geometric: vec3f, to_eye: vec3f, depth: f32, there: bool,
    surface: Surface,
}

fn source_pixel(at: vec2u) -> vec2u {
    return min({{ resolution }}u * at + {{ resolution // 2 }}u, textureDimensions(depth_map) - 1u);
}

// Off its surface, and out of the tents of others (simulator/voxels/starts.py, `cone_start`).
fn cone_start(place: vec3f, geometric: vec3f, to_eye: vec3f) -> vec3f {
    let start = place + {{ offset }} * geometric;
    let clear = lifted(start, geometric, {{ offset }}, 1.0);
    let away = -sign(to_eye);
    let aside = -away * min(facing_voxels(clear, 0u, away), vec3f(1.0));
    return start + aside - dot(aside, geometric) * geometric;
}

fn seen_voxel(at: vec2u) -> SeenVoxel {
    let pixel = source_pixel(at);
    let depth = textureLoad(depth_map, pixel, 0).x;
    let surface = unpack_surface(textureLoad(surface_map, pixel, 0));
    let ray = view_ray(views[0], vec2f(pixel) + 0.5);
    let to_eye = -normalize(ray.direction);
    let geometric = surface.geometric_normal;
    let place = (ray.origin + depth * ray.direction - voxels_of.origin) / voxels_of.size;
    let inside = all(place >= vec3f(0.0)) && all(place <= vec3f(EDGE));
    return SeenVoxel(
        pixel, place, cone_start(place, geometric, to_eye), surface.normal, geometric, to_eye, depth, depth > 0.0 && inside, surface,
    );
}

// Directions that shading normals turn below the surface, mirrored to above it.
fn above(towards: vec3f, geometric: vec3f) -> vec3f {
    return towards - 2.0 * min(0.0, dot(towards, geometric)) * geometric;
}
