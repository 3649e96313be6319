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
