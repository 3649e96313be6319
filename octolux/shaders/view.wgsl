// The ray of a pixel. Both its parts are affine in the pixel's position, so one struct serves perspective (the origin
// is fixed) and orthographic views (the direction is). The direction has unit length along the view's axis: the ray
// parameter is the depth.

struct Ray { origin: vec3f, direction: vec3f }

fn view_ray(view: View, pixel: vec2f) -> Ray {
    return Ray(
        view.origin + pixel.x * view.origin_dx + pixel.y * view.origin_dy,
        view.direction + pixel.x * view.direction_dx + pixel.y * view.direction_dy,
    );
}

// The way at one depth between the rays of two pixels that are `moved` apart.
fn between_rays(view: View, moved: vec2f, depth: f32) -> vec3f {
    return moved.x * (view.origin_dx + depth * view.direction_dx) + moved.y * (view.origin_dy + depth * view.direction_dy);
}

// The projection's inverse of `view_ray`, without the eye's place, in which far from the origin little would be left of a step:
// a point is seen at .xy / .z of a sum of these, `of_pixel` of where it is seen from and `of_step` of ways from there.
fn of_pixel(view: View, pixel: vec2f, depth: f32) -> vec3f {
    return select(vec3f(pixel, 1.0), depth * vec3f(pixel, 1.0), view.perspective != 0u);
}
fn of_step(view: View, way: vec3f) -> vec3f {
    if view.perspective == 0u {
        let across = vec2f(dot(way, view.origin_dx), dot(way, view.origin_dy));
        return vec3f(across / vec2f(dot(view.origin_dx, view.origin_dx), dot(view.origin_dy, view.origin_dy)), 0.0);
    }
    let square = vec2f(dot(view.direction_dx, view.direction_dx), dot(view.direction_dy, view.direction_dy));
    let middle = vec2f(dot(view.direction, view.direction_dx), dot(view.direction, view.direction_dy)) / square;
    let axis = view.direction - middle.x * view.direction_dx - middle.y * view.direction_dy;
    let across = vec2f(dot(way, view.direction_dx), dot(way, view.direction_dy)) / square;
    return vec3f(across - dot(way, axis) * middle, dot(way, axis));
}
