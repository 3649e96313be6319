// The part of a pixel's line of sight that lies in the medium.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/medium.wgsl") }}

// direction: unit. start, length: metres from the origin, and in the medium.
struct Path { origin: vec3f, direction: vec3f, start: f32, length: f32 }

fn path_of(pixel: vec2u) -> Path {
    let ray = view_ray(views[0], vec2f(pixel) + 0.5);
    let depth = textureLoad(depth_map, pixel, 0).x;
    let secant = length(ray.direction);
    let direction = ray.direction / secant;
    let span = medium_span(ray.origin, direction);
    let start = max(span.x, 0.0);
    let end = min(span.y, select(3e38, depth * secant, depth > 0.0));
    return Path(ray.origin, direction, start, max(end - start, 0.0));
}

// 1 - exp(-x), without the cancellation of small x: the next term of the series, x^4 / 24, is 3e-7 of the sum at 0.02.
fn absorbed(x: vec3f) -> vec3f {
    let series = x * (1.0 - x * (0.5 - x * {{ 1 / 6 }}));
    return select(1.0 - exp(-x), series, x < vec3f(0.02));
}

// How far the mean fluence along paths of two lengths may be taken for another: where they part by the share s of the
// longer, a part s of one mean is light that the other has not seen. A tenth counts half, a half less than a 600th.
fn alike(a: f32, b: f32) -> f32 {
    let share = 10.0 * abs(a - b) / max(max(a, b), 1e-20);
    let square = share * share;
    return 1.0 / (1.0 + square * square);
}
