{{ use("techniques/lpv/gathering/planes.wgsl") }}

// Share of light that passes from a node to a point in a cell's middle, unit vector `towards` and `distance` away, in cells
// of level `base` (simulator/lpv/geometry.py, `cone_transmittance`): the march goes on to the next level when it has
// doubled its length, and so never reaches the coarsest, or where it leaves a level's window. `travelled` counts cells
// along the direction's longest component.
fn passing(point: vec3f, towards: vec3f, distance: f32, node_size: f32, base: u32) -> f32 {
    let sizes = abs(towards);
    let is_x = sizes.x >= max(sizes.y, sizes.z);
    let is_y = sizes.y >= sizes.z;
    let along = select(select(point.z, point.y, is_y), point.x, is_x);
    let signed = select(select(towards.z, towards.y, is_y), towards.x, is_x);
    let longest = max(abs(signed), 1e-6);
    let sense = select(-1.0, 1.0, signed > 0.0);
    let step = sizes * ({{ short }} / longest); // cells of a level that a step goes along each axis
    let upwards = towards > vec3f(0.0);
    let whole = distance * longest;
    let last = whole - max({{ left_out }}, 0.5 * node_size) - 0.25;
    var passed = select(0.0, 1.0, distance > 0.0);
    var travelled = 1.0;
    var width = 1.0;
    {% if windows > 1 %}
    var level = base;
    let per_step = {{ 1 / short }} * longest / select(vec3f(1e-6), towards, sizes > vec3f(1e-6)); // cells travelled to go one along each axis
    {% endif %}
    var bits = {{ bits }}u; // of a coordinate
    var first = {{ "%du * base"|format(n**3) if windows > 1 else "%du"|format(shares_first) }};
    loop {
        // How far the steps of this level end in their layers: a layer counts that begins before the last.
        let into = fract((along + sense * travelled) / width);
        let end = last + width * select(1.0 - into, into, sense > 0.0);
        {% if windows > 1 %}
        // Steps that end beyond the window belong to the next level.
        let origin = origin_of(level);
        let bound = width * vec3f(select(origin, origin + {{ n }}, upwards));
        let room = select(vec3f(1e9), (bound - point) * per_step, sizes > vec3f(1e-6));
        let leaves = select(min(room.x, min(room.y, room.z)), 1e9, level >= {{ windows - 1 }}u);
        let stop = min(end, leaves);
        {% else %}
        let origin = vec3i(0);
        let stop = end;
        {% endif %}
        let limit = min(stop, {{ 2 * cone_length }} * width * longest);
        let begin = point * (1.0 / width) - vec3f(origin);
        let ahead = towards * ({{ short }} / (width * longest));
        loop {
            let inside = travelled < stop;
            let at = begin + ahead * travelled;
            let cell = vec3u(clamp(vec3i(floor(at)), vec3i(0), vec3i((1 << bits) - 1)));
            let word = geometry[first + (cell.x | (cell.y << bits) | (cell.z << (2u * bits)))];
            let reach = step * min(1.0, (whole - travelled) / width);
            let through = select(vec3f(1.0), through_planes(word, at, upwards, step, reach), vec3<bool>(inside));
            passed *= through.x * through.y * through.z;
            travelled += select(0.0, width, inside);
            continuing { break if travelled >= limit || passed <= {{ opaque }}; }
        }
        first += 1u << (3u * bits);
        {% if windows > 1 %}
        level += 1u;
        bits -= select(0u, 1u, level >= {{ windows }}u);
        {% else %}
        bits -= 1u;
        {% endif %}
        width *= 2.0;
        continuing { break if travelled >= end || passed <= {{ opaque }}; }
    }
    return passed;
}
