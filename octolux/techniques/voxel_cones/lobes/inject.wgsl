// Injection (VCT 5.5) of light and its moment (simulator/voxels/lobes.py, `lobes_of`): each VPL's flux F into the voxel that
// its point lies in.
//
// Axial intensities would be F n_a / (pi edge^2) each way that the voxel faces (axial/inject.wgsl); light is their sum. Sums
// are in fixed point, of F |n| and of its moment, three times the mean of the channels: whole numbers may be added in any
// order. A moment may point either way, so it has half of the room.
{{ use("techniques/voxel_cones/light/arrival.wgsl") }}

// To the light whose map has a VPL.
fn way_to_light(number: u32, position: vec3f) -> vec3f {
    let view = views[shone.first_view + number / (source.width * source.width)];
    return normalize(select(-view.direction, view.origin - position, view.perspective == 1u));
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + {{ row }}u * id.y;
    if index >= source.count { return; }
    let vpl = load_vpls(source.first + index);
    let arrival = arrival_of(vpl);
    if arrival.square == 0.0 { return; }
    let brick = brick_of_way(ways[arrival.node], 0u) - injected.first;
    if brick >= injected.count { return; }
    let flux = dot(arrival.up + arrival.down, vec3f(1.0)) * inverseSqrt(arrival.square) * vpl.flux;
    let moment = {{ 0.5 / pi }} * source.moment_scale * dot(flux, vec3f(1.0)) * way_to_light(index, vpl.position);
    let light_slot = 3u * (8u * brick + arrival.corner);
    let moment_slot = light_slot + 24u;
    {% for axis in "xyz" %}
    atomicAdd(&sums[light_slot + {{ loop.index0 }}u], u32(round(source.scale.{{ axis }} * flux.{{ axis }})));
    atomicAdd(&sums[moment_slot + {{ loop.index0 }}u], bitcast<u32>(i32(round(moment.{{ axis }}))));
    {% endfor %}
}
