// What a pixel receives through {{ cones }} wide cones (simulator/voxels/cones.py, `gather`): irradiance and ambient
// visibility, and beside them the shading normal and depth that they belong to, for filter.wgsl.
//
// Pixels of a tile have other directions each. Threads that a software adapter runs together take pixels that lie a tile
// apart, so that their cones go the same way and end together.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/gbuffer.wgsl") }}
{{ use("shaders/sample_directions.wgsl") }}
{{ use("techniques/voxel_cones/cones.wgsl") }}
{{ use("techniques/voxel_cones/pixel.wgsl") }}

const TILE = 4u;
const TOGETHER = 8u;

// plane: across which normal the surface lies that it starts on.  before, before_level: of the last sample; the one where a cone leaves the cube is for the way from there, on its level.
struct Way {
    start: vec3f, towards: vec3f, plane: vec3f, reach: f32, before: f32, before_level: u32, traced: Traced,
}

// distance: of the sample in voxels of level 0; step: for which it stands, in voxels of `level`.
fn sampled(way: Way, distance: f32, level: u32, step: f32) -> Way {
    let leaves = distance > way.reach;
    let travelled = min(distance, way.reach);
    let of_level = select(level, way.before_level, leaves);
    let height = {{ offset }} + travelled * dot(way.towards, way.plane);
    let position = lifted(way.start + travelled * way.towards, way.plane, height, f32(1u << of_level));
    let found = sample_voxels(position, of_level, way.towards);
    let rest = max(way.reach - way.before, 0.0) / f32(1u << way.before_level);
    let traced = covered(way.traced, found, select(step, rest, leaves));
    return Way(way.start, way.towards, way.plane, way.reach, distance, level, traced);
}

// plane: unit normal of the surface that it starts on.
fn wide_cone(start: vec3f, towards: vec3f, plane: vec3f, wanted: bool) -> Traced {
    let reach = way_out(start, towards);
    var way = Way(start, towards, plane, reach, 0.0, 0u, Traced(vec3f(0.0), select(0.0, 1.0, wanted)));
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
    return vec2f((f32(reverseBits(phase) >> 28u) + 0.5) * {{ 1 / phases }}, fract(f32(phase) * {{ phase_turn }}));
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let across = TILE * TOGETHER;
    let at = vec2u(id.x / across * across + (id.x % TOGETHER) * TILE + id.x % across / TOGETHER, id.y);
    if any(at >= textureDimensions(light_out)) { return; }
    let seen = seen_voxel(at);
    let shift = phase_shift(at.x % TILE + TILE * (at.y % TILE));
    let basis = basis_of(seen.normal);
    var irradiance = vec3f(0.0);
    var visible = 0.0;
    for (var i = 0u; i < {{ cones }}u; i++) {
        let square = (f32(i) + shift.x) * {{ 1 / cones }};
        let angle = {{ 2 * pi }} * fract(f32(i) * {{ cone_turn }} + shift.y);
        let local = vec3f(sqrt(square) * cos(angle), sqrt(square) * sin(angle), sqrt(1.0 - square));
        let towards = above(from_basis(basis, local), seen.geometric);
        let traced = wide_cone(seen.start, towards, seen.geometric, seen.there);
        irradiance += traced.radiance;
        visible += traced.left;
        {% if sky %}
        irradiance += traced.left * environment_lobe(towards, {{ sky_alpha }});
        {% endif %}
    }
    let shown = select(vec4f(0.0, 0.0, 0.0, 1.0), vec4f({{ pi / cones }} * irradiance, {{ 1 / cones }} * visible), seen.there);
    textureStore(light_out, at, shown);
    textureStore(place_out, at, vec4f(seen.normal, seen.depth));
}
