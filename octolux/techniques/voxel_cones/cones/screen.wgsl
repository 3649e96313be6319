// Where cones first meet what the picture shows (simulator/voxels/screen.py, `screen_way`).

// met: what the picture shows there, on its lit side.  free: voxels of level 0 to there, or so far as nothing was in the way.
// light: that it reflects of direct light, nits; albedo: of what else it receives.
struct ScreenWay { met: bool, free: f32, light: vec3f, albedo: vec3f }

// jitter: of the steps, 0 to 1.
fn screen_way(seen: SeenVoxel, towards: vec3f, jitter: f32) -> ScreenWay {
    let view = views[0];
    let size = vec2f(textureDimensions(depth_map));
    let own = vec2f(seen.pixel) + 0.5;
    let sight = view_ray(view, own).direction;
    let lift = {{ clearance }} * voxels_of.size * seen.geometric;
    let forward = voxels_of.size * towards; // metres, a voxel
    let place = of_pixel(view, own, seen.depth) + of_step(view, lift);
    let place_step = of_step(view, forward);
    var free = 0.0;
    for (var k = 0u; k < {{ screen_steps }}u; k++) {
        let part = (f32(k) + jitter) * {{ 1 / screen_steps }};
        let travelled = {{ screen }} * part * part;
        let projected = place + travelled * place_step;
        let pixel = projected.xy / projected.z;
        if projected.z <= 0.0 || any(pixel < vec2f(0.0)) || any(pixel >= size) { break; }
        let at = vec2u(pixel);
        let depth = textureLoad(depth_map, at, 0).x;
        if depth <= 0.0 { break; }
        let surface = unpack_surface(textureLoad(surface_map, at, 0));
        let shown = (depth - seen.depth) * sight + between_rays(view, vec2f(at) + 0.5 - own, depth);
        let height = dot(lift + travelled * forward - shown, surface.geometric_normal);
        if height > screen.ceiling { break; }
        if height < 0.0 {
            let sinks = -dot(forward, surface.geometric_normal);
            if -height > (travelled - free) * sinks { // it went behind that elsewhere
                free = select(free, min(free, max(travelled + height / sinks, 0.0)), sinks > 0.0);
                break;
            }
            return ScreenWay(true, travelled, textureLoad(reflected_map, at, 0).rgb, diffuse_albedo(surface));
        }
        free = travelled;
    }
    return ScreenWay(false, free, vec3f(0.0), vec3f(0.0));
}
