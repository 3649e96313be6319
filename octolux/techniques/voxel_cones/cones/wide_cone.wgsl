// Wide cones (simulator/voxels/cones.py, `trace`), and where a set of them is turned to
// (simulator/voxels/directions.py).
{{ use("techniques/voxel_cones/cones/cones.wgsl") }}

// plane: across which normal the surface lies that it starts on.  free: voxels of level 0, on which nothing is to be met.
// before, before_level: of the last sample; the one where a cone leaves the cube is for the way from there, on its level.
struct Way {
    start: vec3f, towards: vec3f, plane: vec3f, free: f32, reach: f32, before: f32, before_level: u32, traced: Traced,
}

{% if limited %}
// The share of the last cone that met nothing within air.reach voxels of level 0.
var<private> open: f32;
{% endif %}

// distance: of the sample in voxels of level 0; step: for which it stands, in voxels of `level`.
fn sampled(way: Way, distance: f32, level: u32, step: f32) -> Way {
    let leaves = distance > way.reach;
    let travelled = min(distance, way.reach);
    let of_level = select(level, way.before_level, leaves);
    let height = {{ offset }} + travelled * dot(way.towards, way.plane);
    let position = lifted(way.start + travelled * way.towards, way.plane, height, f32(1u << of_level));
    let found = sample_voxels(position, of_level, way.towards){% if absorbs %} * vec4f(vec3f(through_air(travelled)), 1.0){% endif %};
    let rest = max(way.reach - way.before, 0.0) / f32(1u << way.before_level);
    {% if screen %}
    let whole = select(step, rest, leaves);
    let voxels = max(whole * f32(1u << of_level), 1e-6);
    let length = whole * saturate((travelled + voxels - way.free) / voxels);
    {% else %}
    let length = select(step, rest, leaves);
    {% endif %}
    {% if noted %}if {{ "length > 0.0" if screen else "true" }} { note(position, way.towards, f32(of_level), length, found, way.traced); }{% endif %}
    let traced = covered(way.traced, found, length);
    {% if limited %}
    let within = saturate((air.reach - travelled) / max(length * f32(1u << of_level), 1e-6));
    open -= within * (way.traced.left - traced.left);
    {% endif %}
    return Way(way.start, way.towards, way.plane, way.free, way.reach, distance, level, traced);
}

// plane: unit normal of the surface that it starts on.  free: voxels of level 0 from there, known to be empty, with `screen`.
fn wide_cone(start: vec3f, towards: vec3f, plane: vec3f, free: f32, wanted: bool) -> Traced {
    let reach = way_out(start, towards);
    {% if limited %}open = select(0.0, 1.0, wanted);{% endif %}
    var way = Way(start, towards, plane, free, reach, 0.0, 0u, Traced(vec3f(0.0), select(0.0, 1.0, wanted)));
    {% for sample in near %}
    way = sampled(way, {{ sample.distance }}, 0u, {{ sample.step }});
    {% endfor %}
    var far = 1.0; // how many times as far as on level 0 samples are
    var step = 1.0; // and for how long a way they stand, in voxels of their level
    var level = 0u;
    loop {
        {% for sample in first_level %}
        way = sampled(way, {{ sample.distance }} * far, level, {{ sample.step }} * step);
        {% endfor %}
        far *= 2.0;
        step *= select(1.0, 2.0, level == TOP);
        level = min(level + 1u, TOP);
        continuing { break if way.before >= way.reach || way.traced.left <= {{ left }}; }
    }
    return way.traced;
}

// How far the cones of a pixel's phase are moved: outwards on the disc, and around (`phase_shift`).
fn phase_shift(phase: u32) -> vec2f {
    let place = f32(reverseBits(phase) >> 28u);
    return vec2f((place + 0.5) * {{ 1 / phases }}, fract(place * {{ phase_turn }}));
}

// Of the cone with this number of a set that is moved so: around +z.
fn cone_axis(number: u32, shift: vec2f) -> vec3f {
    let square = (f32(number) + shift.x) * {{ 1 / cones }};
    let angle = {{ 2 * pi }} * fract(f32(number) * {{ cone_turn }} + shift.y);
    return vec3f(sqrt(square) * cos(angle), sqrt(square) * sin(angle), sqrt(1.0 - square));
}
