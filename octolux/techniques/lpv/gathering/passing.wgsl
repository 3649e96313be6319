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
    let size = sizes * ({{ 1 / 255 }} / longest);
    let last = distance * longest - max({{ left_out }}, 0.5 * node_size) - 0.25;
    var passed = select(0.0, 1.0, distance > 0.0);
    var travelled = 0.5;
    var width = 1.0;
    {% if windows > 1 %}
    var level = base;
    let per_step = longest / select(vec3f(1e-6), towards, sizes > vec3f(1e-6)); // cells travelled to go one along each axis
    {% endif %}
    var bits = {{ bits }}u; // of a coordinate
    var first = {{ "%du * base"|format(n**3) if windows > 1 else "%du"|format(shares_first) }};
    loop {
        travelled -= width * fract((along + sense * travelled) / width); // back to a face of this level
        {% if windows > 1 %}
        // Steps whose middle lies beyond the window belong to the next level.
        let origin = origin_of(level);
        let bound = width * vec3f(select(origin, origin + {{ n }}, towards > vec3f(0.0)));
        let room = select(vec3f(1e9), (bound - point) * per_step, sizes > vec3f(1e-6));
        let leaves = select(min(room.x, min(room.y, room.z)) - 0.5 * width, 1e9, level >= {{ windows - 1 }}u);
        let stop = min(last, leaves);
        let limit = min(stop, {{ 2 * cone_length }} * width * longest);
        {% else %}
        let limit = min(last, {{ 2 * cone_length }} * width * longest);
        {% endif %}
        let from_point = point * (1.0 / width);
        let ahead = towards * ({{ short }} / (width * longest));
        loop {
            {% if windows > 1 %}
            let inside = travelled < stop;
            let cell = vec3u(clamp(vec3i(floor(from_point + ahead * (travelled + 0.5 * width))) - origin, vec3i(0), vec3i((1 << bits) - 1)));
            {% else %}
            let inside = travelled < last;
            let cell = vec3u(from_point + ahead * (travelled + 0.5 * width));
            {% endif %}
            let shares = geometry[first + (cell.x | (cell.y << bits) | (cell.z << (2u * bits)))];
            let blocked = dot(vec3f(vec3u(shares, shares >> 8u, shares >> 16u) & vec3u(255u)), size);
            passed *= 1.0 - select(0.0, min(blocked, 1.0), inside);
            travelled += {{ "select(0.0, width, inside)" if windows > 1 else "width" }};
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
        continuing { break if travelled >= last || passed <= {{ opaque }}; }
    }
    return passed;
}
