// The samples of one pixel's cones, a thread for each cone: the diffuse ones as diffuse.wgsl traces them, and the last, if
// `glossy`, as specular.wgsl does.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/reflection.wgsl") }}
{{ use("techniques/voxel_cones/cones/tight_cone.wgsl") }}
{{ use("techniques/voxel_cones/cones/pixel_cone.wgsl") }}

var<private> of_cone: u32;
var<private> count: u32;

fn note(position: vec3f, towards: vec3f, level: f32, step: f32, found: vec4f, before: Traced) {
    if count >= {{ room }}u { return; }
    let share = before.left - covered(before, found, step).left;
    samples[{{ room }}u * of_cone + count] = ConeSample(position, level, towards, step, found.rgb, found.a, share, of_cone);
    count += 1u;
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= {{ diffuse + glossy }}u { return; }
    of_cone = id.x;
    let at = vec2u(chosen.column, chosen.row);
    let seen = seen_voxel(at);
    if id.x == {{ diffuse }}u {
        let towards = reflected_direction(seen.surface, seen.to_eye);
        _ = tight_cone(seen.start, towards, seen.geometric, {{ lobe }} * alpha_of(seen.surface), seen.there);
    } else {
        _ = pixel_cone(seen, basis_of(seen.normal), id.x % {{ cones }}u, phase_shift(first_phase(at) + id.x / {{ cones }}u));
    }
    counts[id.x] = select(0u, count, seen.there);
}
