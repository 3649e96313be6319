// Tight cones (simulator/voxels/cones.py, `specular_light`), for which samples are adjacent.
{{ use("techniques/voxel_cones/cones/cones.wgsl") }}

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

{% set seen_through = " * vec4f(vec3f(through_air(at)), 1.0)" if absorbs else "" %}
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
        let found = sample_between(position, level, towards){{ seen_through }};
        let length = select(0.0, {{ step }}, reading);
        {% if noted %}note(position, towards, level, length, found, traced);{% endif %}
        traced = covered(traced, found, length);
        let across = way_out_of_cell(position, looked_at, towards);
        travelled += select(select(0.0, {{ step }} * size, reading), max({{ step }} * size, across), empty);
        looked_at = select(max(looked_at, finest + 1u) - 1u, min(looked_at + 1u, TOP), empty);
        {% else %}
        let found = sample_between(position, level, towards){{ seen_through }};
        {% if noted %}note(position, towards, level, {{ step }}, found, traced);{% endif %}
        traced = covered(traced, found, {{ step }});
        travelled += {{ step }} * size;
        {% endif %}
        continuing { break if travelled >= reach || traced.left <= {{ left }}; }
    }
    return traced;
}
