{{ use("techniques/lpv/gathering/planes.wgsl") }}

// A level: its first cell's number, bits of a coordinate, where the way begins, in its cells, and one over how wide they are.
struct Level { first: u32, bits: u32, begin: vec3f, per_cell: f32 }
// A way: cells that it goes along each axis while it goes one along its longest component, which it has `whole` of.
struct Way { step: vec3f, size: vec3f, upwards: vec3<bool>, whole: f32 }
// A cone to a node: the node's size, how far it goes on from its light towards the point, and the cone's length over the
// size of cells half as wide as it.
struct Cone { node_size: f32, room: f32, length: f32 }

// What the strips of the cell let through in which a step of a level ends after `travelled` (planes.wgsl){% if windows > 1 %}, or at the start. The
// start's own cell is not part of it: `own` of what has been travelled{% endif %}.
fn let_through(level: Level, way: Way, travelled: f32{% if windows > 1 %}, own: f32{% endif %}) -> f32 {
    let ends = {{ "clamp(travelled, 0.0, way.whole)" if windows > 1 else "min(travelled, way.whole)" }};
    let at = level.begin + (level.per_cell * ends) * way.step;
    let cell = vec3u(clamp(vec3i(floor(at)), vec3i(0), vec3i((1 << level.bits) - 1)));
    let words = geometry[level.first + (cell.x | (cell.y << level.bits) | (cell.z << (2u * level.bits)))];
    let back = {{ "way.size * min(1.0, level.per_cell * (ends - own))" if windows > 1 else "way.size" }};
    let through = through_strips(words, at, way, back, way.size * min(1.0, level.per_cell * (way.whole - ends)));
    return through.x * through.y * through.z;
}

// What a cell's strips let through of a step that ends `at` (are_crossed), each as far as it is there (simulator/lpv/strips.py,
// `Strips.cover`). Where the way is beside the cell when it crosses a plane, the cell's side counts.
fn through_strips(words: vec4u, at: vec3f, way: Way, back: vec3f, ahead: vec3f) -> vec3f {
    let part = fract(at);
    let plane = select(1.0 - planes_of(words), planes_of(words), way.upwards);
    let within = select(1.0 - part, part, way.upwards);
    let further = (plane - within) / max(way.size, vec3f(1e-6)); // steps from where this one ends to the plane
    let along_last = are_along_last(words);
    let start = select(part.yzx, part.zxy, along_last);
    let place = clamp(start + further * select(way.step.yzx, way.step.zxy, along_last), vec3f(0.0), vec3f(1.0));
    let low = lows_of(words);
    let high = highs_of(words);
    let half = 0.5 * (high - low);
    let from_low = saturate(0.5 + 0.5 * (place - low) / max(min(low, half), vec3f({{ 0.5 / strip_steps }})));
    let to_high = saturate(0.5 + 0.5 * (high - place) / max(min(1.0 - high, half), vec3f({{ 0.5 / strip_steps }})));
    let cover = select(from_low, vec3f(1.0), low == vec3f(0.0)) * select(to_high, vec3f(1.0), high == vec3f(1.0));
    return vec3f(1.0) - select(vec3f(0.0), densities_of(words) * cover, are_crossed(plane, within, back, ahead));
}

// How far in its layer of cells so wide a way is, from 0 to 1.
fn into_layer(along: f32, sense: f32, travelled: f32, width: f32) -> f32 {
    let into = fract((along + sense * travelled) / width);
    return select(1.0 - into, into, sense > 0.0);
}

// Share of light that passes from a node to a point in a cell's middle, unit vector `towards` and `distance` away, in cells
// of level `base` (simulator/lpv/cones.py, `cone_transmittance`): the march goes on to the next level when it has
// doubled its length, and so never reaches the coarsest, or where a level's window ends. `travelled` counts cells along the
// direction's longest component.
fn passing(point: vec3f, towards: vec3f, distance: f32, cone: Cone, base: u32) -> f32 {
    let sizes = abs(towards);
    let is_x = sizes.x >= max(sizes.y, sizes.z);
    let is_y = sizes.y >= sizes.z;
    let along = select(select(point.z, point.y, is_y), point.x, is_x);
    let signed = select(select(towards.z, towards.y, is_y), towards.x, is_x);
    let longest = max(abs(signed), 1e-6);
    let sense = select(-1.0, 1.0, signed > 0.0);
    let way = Way(towards * ({{ short }} / longest), sizes * ({{ short }} / longest), towards > vec3f(0.0), distance * longest);
    let own = min(0.5 * cone.node_size, cone.room * longest);
    let layers = way.whole - max({{ left_out }}, own) - 0.25; // that begin before this count
    let doubles = 2.0 * cone.length * longest; // where the next level is wide enough, over the width of this one
    var passed = select(0.0, 1.0, distance > 0.0);
    var travelled = 1.0;
    var width = 1.0;
    {% if windows > 1 %}
    let last = select(-1e9, layers, layers > 0.5); // nothing but the start's own cell
    var level = base;
    var here = Level({{ n**3 }}u * base, {{ bits }}u, point - vec3f(origin_of(base)), 1.0);
    let per_step = {{ 1 / short }} * longest / select(vec3f(1e-6), towards, sizes > vec3f(1e-6)); // cells travelled to go one along each axis
    {% else %}
    let last = layers;
    var here = Level({{ strips_first }}u, {{ bits }}u, point, 1.0);
    {% endif %}
    loop {
        // Steps count as long as their layers begin before the last.
        let end = last + width * into_layer(along, sense, travelled, width);
        {% if windows > 1 %}
        // Before a window ends, pairs of its steps give way to steps of the next level, which end with the second of each
        // wherever the window does. The ends follow the camera without steps. So nothing jumps; `pair` is the first of these.
        let gives_way = level < {{ windows - 1 }}u;
        let room = select(vec3f(1e9), (width * end_of(level, way.upwards) - point) * per_step, sizes > vec3f(1e-6));
        let leaves = min((doubles + {{ fade }}) * width, min(room.x, min(room.y, room.z)));
        var pair = travelled - select(0.0, width, into_layer(along, sense, travelled, 2.0 * width) >= 0.5);
        pair += 2.0 * width * max(0.0, floor((leaves - pair - {{ fade - 1 }} * width) / (2.0 * width)));
        let stop = min(end, select(1e9, pair, gives_way));
        let limit = min(stop, select(doubles * width, 1e9, gives_way));
        let own = select(0.5, 0.0, level == base);
        {% else %}
        let stop = end;
        let limit = min(stop, doubles * width);
        {% endif %}
        loop {
            let inside = travelled < stop;
            passed *= select(1.0, let_through(here, way, travelled{% if windows > 1 %}, own{% endif %}), inside);
            travelled += select(0.0, width, inside);
            continuing { break if travelled >= limit || passed <= {{ opaque }}; }
        }
        var next = Level(here.first + (1u << (3u * here.bits)), here.bits - 1u, 0.5 * here.begin, 0.5 * here.per_cell);
        {% if windows > 1 %}
        next.bits = here.bits - select(0u, 1u, level + 1u >= {{ windows }}u);
        next.begin = next.per_cell * point - vec3f(origin_of(level + 1u));
        if gives_way && pair < end + 2.0 * width && passed > {{ opaque }} {
            loop {
                let second = pair + width;
                let goes_on = pair < end + 2.0 * width && second < leaves;
                let fine = select(1.0, let_through(here, way, pair, own), pair >= travelled && pair < end)
                    * select(1.0, let_through(here, way, second, own), second < end);
                let coarse = let_through(next, way, pair - width, 0.5); // with the pair before
                let share = saturate((leaves - second) / ({{ fade }} * width));
                passed *= select(1.0, mix(coarse, fine, share), goes_on);
                pair += select(0.0, 2.0 * width, goes_on);
                continuing { break if !goes_on || passed <= {{ opaque }}; }
            }
        }
        travelled = select(travelled, pair - width, gives_way);
        // A step of the next level counts up to a cell later, and if pairs of that give way to steps, six more.
        let most = end + select(0.0, width * select(1.0, 7.0, level + 2u < {{ windows }}u), gives_way);
        level += 1u;
        {% else %}
        let most = end;
        {% endif %}
        here = next;
        width *= 2.0;
        continuing { break if travelled >= most || passed <= {{ opaque }}; }
    }
    return passed;
}
