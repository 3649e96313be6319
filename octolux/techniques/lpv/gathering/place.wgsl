// Where a pixel's surface is looked up: in which window, in cells from its corner, and how much of what is read comes from it
// (simulator/lpv/cascades.py, `weights`); the rest comes from the next.
struct SeenPlace { inside: bool, surface: vec3f, geometric_normal: vec3f, normal: vec3f }

fn seen_place(pixel: vec2u) -> SeenPlace {
    let depth = textureLoad(depth_map, pixel, 0).x;
    let ray = view_ray(views[0], vec2f(pixel) + 0.5);
    let s = unpack_surface(textureLoad(surface_map, pixel, 0));
    let surface = ray.origin + depth * ray.direction;
    let whole = (surface - grids[{{ windows - 1 }}].origin) / grids[{{ windows - 1 }}].cell_size;
    let inside = depth > 0.0 && all(whole >= vec3f(0.0)) && all(whole <= vec3f({{ n }}.0));
    return SeenPlace(inside, surface, s.geometric_normal, s.normal);
}

struct Reading { window: u32, share: f32 }

fn place_in(window: u32, seen: SeenPlace) -> vec3f {
    let grid = grids[window];
    return (seen.surface - grid.origin) / grid.cell_size + {{ lookup_offset }} * seen.geometric_normal;
}

{% if windows > 1 %}
fn share_of(window: u32, place: vec3f) -> f32 {
    let room = min(place - windows[window].low, windows[window].high - place);
    return saturate(min(room.x, min(room.y, room.z)) * {{ 1 / transition }});
}
{% endif %}

fn finest_reading(seen: SeenPlace) -> Reading {
    var reading = Reading({{ windows - 1 }}u, 1.0);
    {% for i in range(windows - 1)|reverse %}
    let share_{{ i }} = share_of({{ i }}u, place_in({{ i }}u, seen));
    if share_{{ i }} > 0.0 { reading = Reading({{ i }}u, share_{{ i }}); }
    {% endfor %}
    return reading;
}
