// What a pixel receives through {{ cones }} wide cones (simulator/voxels/cones.py, `gather`): irradiance and ambient
// visibility, and beside them the shading normal and depth that they belong to, for filter.wgsl.
//
// Pixels of a tile have other directions each. Threads that a software adapter runs together take pixels that lie a tile
// apart, so that their cones go the same way and end together.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/gbuffer.wgsl") }}
{{ use("shaders/sample_directions.wgsl") }}
{{ use("techniques/voxel_cones/cones/wide_cone.wgsl") }}
{{ use("techniques/voxel_cones/cones/pixel.wgsl") }}

const TILE = 4u;
const TOGETHER = 8u;

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
        let towards = above(from_basis(basis, cone_axis(i, shift)), seen.geometric);
        let traced = wide_cone(seen.start, towards, seen.geometric, seen.there);
        irradiance += traced.radiance;
        visible += {{ "open" if limited else "traced.left" }};
        {% if sky %}
        irradiance += {% if absorbs %}through_air(way_out(seen.start, towards)) * {% endif %}traced.left * environment_lobe(towards, {{ sky_alpha }});
        {% endif %}
    }
    let shown = select(vec4f(0.0, 0.0, 0.0, 1.0), vec4f({{ pi / cones }} * irradiance, {{ 1 / cones }} * visible), seen.there);
    textureStore(light_out, at, shown);
    textureStore(place_out, at, vec4f(seen.normal, select(0.0, seen.depth, seen.there)));
}
