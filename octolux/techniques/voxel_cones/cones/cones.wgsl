// Cones through voxels (simulator/voxels/cones.py). They know nothing of how voxels are kept but
//     fn sample_voxels(position: vec3f, level: u32, direction: vec3f) -> vec4f
// of file `voxels`: what is met around `position`, in voxels of level 0 from the cube's corner and inside it, on a way along
// the unit vector that is as long as an edge of the level's voxels: radiance times opacity, and opacity. Trilinear. And of
//     fn facing_voxels(position: vec3f, level: u32, direction: vec3f) -> vec3f
// the opacity of three such ways along the axes, times the parts of `direction`, whose signs say where they go.
//
// With `noted` a shader has
//     fn note(position: vec3f, towards: vec3f, level: f32, step: f32, found: vec4f, before: Traced)
// which is told of each sample and of what its cone had met before.
{{ use(voxels) }}

const TOP = {{ depth - 1 }}u; // the coarsest level, of 2^3 voxels
const EDGE = {{ 2 ** depth }}.0; // of the cube, in voxels of level 0

// radiance: of what has been met, for what it covers.  left: share of the cone that has met nothing.
struct Traced { radiance: vec3f, left: f32 }

// step: for which the sample stands, in voxels of its level.
fn covered(so_far: Traced, found: vec4f, step: f32) -> Traced {
    {% if cover == "surfaces" %}
    let share = min(so_far.left, found.a * step);
    {% else %}
    let share = so_far.left * (1.0 - pow(max(1.0 - found.a, 0.0), step));
    {% endif %}
    let scale = select(0.0, share / max(found.a, 1e-20), found.a > 0.0);
    return Traced(so_far.radiance + scale * found.rgb, so_far.left - share);
}

{% if absorbs %}
// What the air leaves of light on a way of this many voxels of level 0 (Beer and Lambert).
fn through_air(travelled: f32) -> f32 { return exp(-air.absorbed * travelled); }
{% endif %}

// Voxels from `start` to where a way leaves the cube; 0 outside.
fn way_out(start: vec3f, towards: vec3f) -> f32 {
    let steep = select(vec3f(1e-12), towards, abs(towards) > vec3f(1e-12));
    let far = (select(vec3f(0.0), vec3f(EDGE), steep > vec3f(0.0)) - start) / steep;
    return max(min(far.x, min(far.y, far.z)), 0.0);
}

// A sample's place, `height` above the plane across `normal` that its cone starts on; lifted where its voxels, of this
// size, would reach that plane (simulator/voxels/cones.py, CLEAR).
fn lifted(position: vec3f, normal: vec3f, height: f32, size: f32) -> vec3f {
    let clear = {{ clear }} * size * dot(abs(normal), vec3f(1.0));
    return clamp(position + max(clear - height, 0.0) * normal, vec3f(0.0), vec3f(EDGE));
}
