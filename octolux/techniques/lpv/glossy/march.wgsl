// Radiance, still scaled for storage, that comes to a point out of a direction (simulator/lpv/glossy.py, `march`): through cells
// of level `base`, and of coarser ones where windows end or `cone`, the edge that resolves the lobe over the way, has grown.
{{ use("techniques/lpv/gathering/levels.wgsl") }}
{{ use("techniques/lpv/gathering/planes.wgsl") }}

const TOP = {{ used - 1 }}u;

// Where a level is read, in cells from its first.
fn is_read_at(level: u32, at: vec3f) -> bool {
    var low = vec3f(0.0);
    var high = vec3f(f32(edge_of(level)));
    {% for i in range(windows - 1) %}
    low = select(low, windows[{{ i }}].low, level == {{ i }}u);
    high = select(high, windows[{{ i }}].high, level == {{ i }}u);
    {% endfor %}
    return all(at >= low) && all(at <= high);
}

// A step on a level: its middle, in cells from the level's first; and whether it is made there, or on the next level.
struct Step { at: vec3f, here: bool, up: bool }

fn step_of(point: vec3f, towards: vec3f, level: u32, middle: f32, cone: f32) -> Step {
    let per_cell = 1.0 / f32(1u << level);
    let at = per_cell * (point + towards * ({{ short }} * middle)) - vec3f(origin_of(level));
    let held = is_read_at(level, at);
    let up = level < TOP && (!held || cone * middle * per_cell >= 2.0);
    return Step(at, held && !up, up);
}

// Where the volumes of an octant are sampled for a place, in cells from the level's first (surfaces.wgsl).
fn texel_of(level: u32, octant: f32, place: vec3f) -> vec3f {
    let edge = f32(edge_of(level));
    let held = clamp(place, vec3f(0.5), vec3f(edge - 0.5));
    let aside = select(0.0, {{ n }}.0 - 2.0 * edge, level >= WINDOWS);
    let slot = {{ n }}.0 * vec3f(0.0, f32(min(level, WINDOWS)), octant);
    return (held + vec3f(aside, 0.0, 0.0) + slot) * vec3f({{ 1 / n }}, {{ 1 / (n * slots) }}, {{ 1 / (8 * n) }});
}

// The mean of the surfaces around there.
fn radiance_at(texel: vec3f) -> vec3f {
    let light = textureSampleLevel(radiance_volume, volume_sampler, texel, 0.0);
    return light.rgb / max(light.a, 1e-6);
}

fn incident(point: vec3f, direction: vec3f, base: u32, cone_of_way: f32, wanted: bool) -> vec3f {
    let lengths = abs(direction);
    let is_x = lengths.x >= max(lengths.y, lengths.z);
    let is_y = lengths.y >= lengths.z;
    let along = select(select(point.z, point.y, is_y), point.x, is_x);
    let sense = select(-1.0, 1.0, select(select(direction.z, direction.y, is_y), direction.x, is_x) > 0.0);
    // All ways are counted along the longest component from here on.
    let per_way = 1.0 / max(max(lengths.x, max(lengths.y, lengths.z)), 1e-6);
    let towards = per_way * direction;
    let sizes = abs(towards);
    let cone = per_way * cone_of_way;
    let upwards = towards > vec3f(0.0);
    let octant = dot(select(vec3f(0.0), vec3f(1.0, 2.0, 4.0), upwards), vec3f(1.0));
    var level = base;
    var width = {{ step }} * f32(1u << base);
    var travelled = -width * fract(sense * along / width); // from a face between steps
    var now = step_of(point, towards, level, travelled + 0.5 * width, cone);
    var before = 0.0;
    var reached = 0.0;
    var left = select(0.0, 1.0, wanted);
    var passed = 1.0;
    var since = 0.0;
    let around = radiance_at(texel_of(level, octant, (1.0 / f32(1u << level)) * point - vec3f(origin_of(level))));
    var front = {{ near }} * vec4f(around, 1.0);
    var sum = vec3f(0.0);
    var steps = 0u;
    loop {
        let per_cell = 1.0 / f32(1u << level);
        let edge = edge_of(level);
        let origin = vec3f(origin_of(level));
        let end = travelled + width;
        let begin = max(travelled, reached);
        let place = per_cell * (point + towards * (0.5 * (begin + end))) + {{ look_ahead }} * towards - origin;
        let texel = texel_of(level, octant, place);
        let facing = textureSampleLevel(facing_volume, volume_sampler, texel, 0.0).xyz;
        let covers = select(0.0, dot(facing, sizes) * ((end - begin) * per_cell), now.here);
        let radiance = radiance_at(texel);
        let share = min(left, covers);
        sum += share * radiance;
        left -= share;
        front = select(1.0, {{ forgets }}, now.here) * front + covers * vec4f(radiance, 1.0);

        let middle = travelled + 0.5 * width;
        let next_level = level + select(0u, 1u, now.up);
        let next_width = {{ step }} * f32(1u << next_level);
        let from_face = select(travelled - next_width * fract((sense * along + travelled) / next_width), end, now.here);
        let next = step_of(point, towards, next_level, from_face + 0.5 * next_width, cone);
        {% if occlusion %}
        let cell = vec3u(clamp(vec3i(floor(now.at)), vec3i(0), vec3i(i32(edge) - 1)));
        let words = geometry[first_of(level) + cell.x + edge * (cell.y + edge * cell.z)];
        let ahead = width * select(1.0, 1.5, next.up); // the first middle of a coarser level is up to so far away
        let within = select(1.0 - fract(now.at), fract(now.at), upwards);
        let plane = select(1.0 - planes_of(words), planes_of(words), upwards);
        let crossed = are_crossed(plane, within, per_cell * (middle - before) * sizes, per_cell * ahead * sizes);
        let through = vec3f(1.0) - select(vec3f(0.0), shares_of(words), crossed);
        let unmet = min(vec3f(1.0), through + {{ met }} * saturate((middle - since) * per_cell - 2.0) * front.a);
        passed *= select(1.0, unmet.x * unmet.y * unmet.z, now.here);
        let blocked = max(0.0, left - passed);
        sum += blocked / max(front.a, {{ least }}) * front.rgb;
        left -= blocked;
        {% endif %}
        before = select(before, middle, now.here);
        reached = select(reached, end, now.here);
        since = select(since, reached, now.up);
        steps += select(0u, 1u, now.here);
        let going = now.here || now.up;
        now = next;
        level = next_level;
        width = next_width;
        travelled = from_face;
        continuing { break if !going || left <= {{ left }} || steps >= {{ steps }}u; }
    }
    return sum;
}
