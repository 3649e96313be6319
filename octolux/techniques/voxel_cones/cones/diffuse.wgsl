// What a pixel receives through sets of {{ cones }} wide cones (simulator/voxels/cones.py, `gather`): irradiance and ambient
// visibility, and beside them the shading normal and depth that they belong to, for filter.wgsl.
//
// Pixels of a tile have other directions each. Threads that a software adapter runs together take pixels that lie a tile
// apart, so that their cones go the same way and end together.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/gbuffer.wgsl") }}
{{ use("techniques/voxel_cones/cones/pixel_cone.wgsl") }}

const TILE = {{ tile }}u;
const TOGETHER = 8u;

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let across = TILE * TOGETHER;
    let at = vec2u(id.x / across * across + (id.x % TOGETHER) * TILE + id.x % across / TOGETHER, id.y);
    if any(at >= textureDimensions(light_out)) { return; }
    let seen = seen_voxel(at);
    let basis = basis_of(seen.normal);
    var found = vec3f(0.0);
    var sky = vec3f(0.0);
    var albedo = vec3f(0.0);
    var visible = 0.0;
    let first = first_phase(at);
    for (var phase = first; phase < first + SETS; phase++) {
        let shift = phase_shift(phase);
        for (var i = 0u; i < {{ cones }}u; i++) {
            let cone = pixel_cone(seen, basis, i, shift);
            found += cone.traced.radiance;
            albedo += cone.albedo;
            visible += {{ "open" if limited else "cone.traced.left" }};
            {% if sky %}
            sky += {% if absorbs %}through_air(way_out(seen.start, cone.towards)) * {% endif %}cone.traced.left * environment_lobe(cone.towards, {{ sky_alpha }});
            {% endif %}
        }
    }
    const EACH = 1.0 / f32({{ cones }}u * SETS);
    {% if screen %}
    // What the screen shows nearby receives what the pixel does, reflected once less often.
    var light = vec3f(0.0);
    for (var n = 0u; n < {{ bounces }}u; n++) { light = found + EACH * albedo * (light + sky); }
    light += sky;
    {% else %}
    let light = found + sky;
    {% endif %}
    let shown = select(vec4f(0.0, 0.0, 0.0, 1.0), EACH * vec4f({{ pi }} * light, visible), seen.there);
    textureStore(light_out, at, shown);
    textureStore(place_out, at, vec4f(seen.normal, select(0.0, seen.depth, seen.there)));
}
