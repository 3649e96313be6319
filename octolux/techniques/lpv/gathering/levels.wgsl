// Levels of cells, one behind the other: {{ windows }} nested windows of {{ n }}^3, the finest first, then what an octree above the
// last of them has (simulator/lpv/cascades.py). Cells are counted in their level from the corner of the whole volume.
const WINDOWS = {{ windows }}u;

fn edge_of(level: u32) -> u32 { return {{ n }}u >> (max(level, {{ windows - 1 }}u) - {{ windows - 1 }}u); }

// Cells of all finer levels: those of windows, and n^3 (1 + 1/8 + ...) up to the level's own.
fn first_of(level: u32) -> u32 {
    let edge = edge_of(level);
    return {{ n**3 }}u * min(level, {{ windows - 1 }}u) + 8u * (({{ n**3 }}u - edge * edge * edge) / 7u);
}

// The first cell of a level that is kept.
fn origin_of(level: u32) -> vec3i {
    var origin = vec3i(0);
    {% for i in range(windows - 1) %}
    origin = select(origin, windows[{{ i }}].origin, level == {{ i }}u);
    {% endfor %}
    return origin;
}

{% if windows > 1 %}
// Where along each axis a window surely has cells, whichever way it has been snapped (simulator/lpv/cascades.py, `Window.ends`).
fn end_of(level: u32, upwards: vec3<bool>) -> vec3f {
    var end = vec3f(0.0);
    {% for i in range(windows - 1) %}
    let end_{{ i }} = vec3f(windows[{{ i }}].origin) + select(windows[{{ i }}].low - 0.5, windows[{{ i }}].high + 0.5, upwards);
    end = select(end, end_{{ i }}, level == {{ i }}u);
    {% endfor %}
    return end;
}
{% endif %}

fn is_kept(level: u32, cell: vec3i) -> bool {
    let at = cell - origin_of(level);
    return all(at >= vec3i(0)) && all(at < vec3i(i32(edge_of(level))));
}

// Of a cell that is kept.
fn number_of(level: u32, cell: vec3i) -> u32 {
    let edge = edge_of(level);
    let at = vec3u(cell - origin_of(level));
    return first_of(level) + at.x + edge * (at.y + edge * at.z);
}
