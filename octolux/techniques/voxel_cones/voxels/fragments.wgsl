// Voxel fragments (simulator/voxels/fragments.py): what of a column of voxels a triangle covers, and the voxel it is in.
// A thread has a tile of a triangle's columns, so that large triangles are shared among many.
{{ use("techniques/voxel_cones/octree/columns.wgsl") }}

// Two axes across, then the one along which the triangle is projected. Corners less `origin`; slopes: of the depth.
struct Projected { axis: u32, origin: vec3f, e1: vec3f, e2: vec3f, normal: vec3f, slopes: vec2f }
// first: column; size: columns across, none where the triangle covers no sample.
struct Columns { first: vec2i, size: vec2u }
// weights: of the second and third corner, in the middle of what is covered.
struct Covered { samples: u32, weights: vec2f }

// Corners in voxels.
fn projected(a: vec3f, b: vec3f, c: vec3f) -> Projected {
    let n = cross(b - a, c - a);
    let axis = dominant_axis(n);
    let normal = turned(n, axis);
    return Projected(axis, turned(a, axis), turned(b - a, axis), turned(c - a, axis), normal, normal.xy / normal.z);
}

fn columns_of(t: Projected) -> Columns {
    let low = t.origin.xy + min(min(t.e1.xy, t.e2.xy), vec2f(0.0));
    let high = t.origin.xy + max(max(t.e1.xy, t.e2.xy), vec2f(0.0));
    // The first and the last of the samples that lie in the triangle's box.
    let aside = vec2f({{ 0.5 / samples + aside[0] }}, {{ 0.5 / samples + aside[1] }});
    let from_column = turned_integers(cube.begin, t.axis).xy;
    let to_column = turned_integers(cube.last, t.axis).xy;
    let first = max(vec2i(ceil({{ samples }}.0 * (low - aside))), {{ samples }} * from_column);
    let last = min(vec2i(floor({{ samples }}.0 * (high - aside))), {{ samples }} * to_column + {{ samples - 1 }});
    let size = max(last / {{ samples }} - first / {{ samples }} + 1, vec2i(0));
    let some = all(last >= first) && t.normal.z != 0.0;
    return Columns(first / {{ samples }}, select(vec2u(0u), vec2u(size), some));
}

fn tiles_of(columns: Columns) -> vec2u { return (columns.size + {{ tile - 1 }}u) / {{ tile }}u; }

fn covered(t: Projected, column: vec2i) -> Covered {
    let at = vec2f(column) - t.origin.xy;
    let over = 1.0 / t.normal.z;
    let gradient_2 = vec2f(t.e2.y, -t.e2.x) * over;
    let gradient_3 = vec2f(-t.e1.y, t.e1.x) * over;
    let base = vec2f(dot(at, gradient_2), dot(at, gradient_3));
    var sum = vec3f(0.0);
    {% for y in range(samples) %}
    {% for x in range(samples) %}
    {
        let offset = vec2f({{ (x + 0.5) / samples + aside[0] }}, {{ (y + 0.5) / samples + aside[1] }});
        let w = base + vec2f(dot(offset, gradient_2), dot(offset, gradient_3));
        sum += select(vec3f(0.0), vec3f(w, 1.0), min(min(w.x, w.y), 1.0 - w.x - w.y) >= 0.0);
    }
    {% endfor %}
    {% endfor %}
    return Covered(u32(sum.z), sum.xy / max(sum.z, 1.0));
}

// Where the plane passes the middle of a column: x, y, z.
fn voxel_of(t: Projected, column: vec2i) -> vec3i {
    let depth = t.origin.z - dot(vec2f(column) + 0.5 - t.origin.xy, t.slopes);
    return turned_back(vec3i(column, i32(floor(depth + {{ bias }}))), t.axis);
}

fn in_cube(voxel: vec3i) -> bool { return all(voxel >= vec3i(0)) && all(voxel < vec3i({{ n }})); }

{% if starts is defined %}
// The triangle that a tile is of: the last whose tiles start at or before it. starts: of count + 1 triangles.
fn triangle_of(tile: u32, count: u32) -> u32 {
    var low = 0u;
    var high = count;
    loop {
        let middle = (low + high) / 2u;
        let before = load_starts(middle) <= tile;
        low = select(low, middle, before);
        high = select(middle, high, before);
        if high - low <= 1u { break; }
    }
    return low;
}

// The columns of one of a triangle's tiles.
fn tile_columns(columns: Columns, tile: u32) -> Columns {
    let across = tiles_of(columns).x;
    let corner = {{ tile }}u * vec2u(tile % across, tile / across);
    return Columns(columns.first + vec2i(corner), min(columns.size - corner, vec2u({{ tile }}u)));
}
{% endif %}
