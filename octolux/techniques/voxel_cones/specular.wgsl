// What a pixel reflects through a tight cone (simulator/voxels/cones.py, `specular_light`), weighted by its BRDF. At a share
// of the resolution only the light, and the normal and depth that it belongs to, are kept for reflect_all.wgsl.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/reflection.wgsl") }}
{{ use("techniques/voxel_cones/cones.wgsl") }}
{{ use("techniques/voxel_cones/pixel.wgsl") }}

// Between levels (VCT 5.6, quadrilinear).
fn sample_between(position: vec3f, level: f32, towards: vec3f) -> vec4f {
    let lower = u32(level);
    let upper = min(lower + 1u, TOP);
    return mix(sample_voxels(position, lower, towards), sample_voxels(position, upper, towards), level - f32(lower));
}

{% if skip %}
// Voxels from `position` to where the way leaves the cell of `is_empty`.
fn way_out_of_cell(position: vec3f, level: u32, towards: vec3f) -> f32 {
    let edge = f32(2u << level);
    let middle = 0.25 * edge; // cells begin in the middle of voxels
    let cell = floor((position - middle) / edge);
    let steep = select(vec3f(1e-12), towards, abs(towards) > vec3f(1e-12));
    let far = (edge * (cell + select(vec3f(0.0), vec3f(1.0), steep > vec3f(0.0))) + middle - position) / steep;
    return max(min(far.x, min(far.y, far.z)), 0.0);
}
{% endif %}

// plane: unit normal of the surface that it starts on.
fn tight_cone(start: vec3f, towards: vec3f, plane: vec3f, widening: f32, wanted: bool) -> Traced {
    var traced = Traced(vec3f(0.0), select(0.0, 1.0, wanted));
    let reach = way_out(start, towards);
    var travelled = 0.0;
    {% if skip %}
    var looked_at = 0u; // the level that is looked for empty cells on
    {% endif %}
    loop {
        let size = clamp(widening * travelled, 1.0, {{ 2 ** (depth - 1) }}.0);
        let level = log2(size);
        let at = min(travelled + {{ 0.5 * step }} * size, reach);
        let position = lifted(start + at * towards, plane, {{ offset }} + at * dot(towards, plane), size);
        {% if skip %}
        // Cells that hold nothing are left in one step, and larger ones are tried; else smaller ones, down to those that
        // the cone samples.
        let finest = min(u32(ceil(level)), TOP);
        looked_at = max(looked_at, finest);
        let empty = is_empty(position, looked_at);
        let reading = !empty && looked_at == finest;
        traced = covered(traced, sample_between(position, level, towards), select(0.0, {{ step }}, reading));
        let across = way_out_of_cell(position, looked_at, towards);
        travelled += select(select(0.0, {{ step }} * size, reading), max({{ step }} * size, across), empty);
        looked_at = select(max(looked_at, finest + 1u) - 1u, min(looked_at + 1u, TOP), empty);
        {% else %}
        traced = covered(traced, sample_between(position, level, towards), {{ step }});
        travelled += {{ step }} * size;
        {% endif %}
        continuing { break if travelled >= reach || traced.left <= {{ left }}; }
    }
    return traced;
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(light_out)) { return; }
    let seen = seen_voxel(id.xy);
    let albedo = lobe_albedo(seen.surface, seen.to_eye);
    let wanted = seen.there && any(albedo > vec3f({{ darkest }}));
    let towards = reflected_direction(seen.surface, seen.to_eye);
    let traced = tight_cone(seen.start, towards, seen.geometric, {{ lobe }} * alpha_of(seen.surface), wanted);
    {% if resolution > 1 %}
    textureStore(light_out, id.xy, vec4f(traced.radiance, 1.0));
    textureStore(place_out, id.xy, vec4f(seen.normal, select(0.0, seen.depth, wanted)));
    {% else %}
    textureStore(light_out, id.xy, vec4f(albedo * traced.radiance, 1.0));
    {% endif %}
}
