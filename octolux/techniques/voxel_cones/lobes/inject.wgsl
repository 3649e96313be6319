// Injection (VCT 5.5) of light and its moment (simulator/voxels/lobes.py, `lobes_of`): each VPL's flux F into the voxel that
// its point lies in.
//
// Axial intensities would be F n_a / (pi edge^2) each way that the voxel faces (axial/inject.wgsl); light is their sum. Sums
// are in fixed point, of F |n| and of its moment, three times the mean of the channels: whole numbers may be added in any
// order. A moment may point either way, so it has half of the room.
{{ use("shaders/octahedral.wgsl") }}
{{ use("techniques/voxel_cones/octree/leaves.wgsl") }}
{{ use("techniques/voxel_cones/bricks/facing.wgsl") }}

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
    let normal = unpack_unit_vector(vpl.normal);
    let leaf = leaf_of_surface(to_voxels(vpl.position), normal);
    if leaf.node == NO_NODE || all(vpl.flux == vec3f(0.0)) { return; }
    let brick = brick_of_way(ways[leaf.node], 0u) - injected.first;
    let shares = facing[8u * leaf.node + leaf.corner];
    let up = select(vec3f(0.0), max(normal, vec3f(0.0)), unpack_shares(shares.x) > vec3f(0.0));
    let down = select(vec3f(0.0), max(-normal, vec3f(0.0)), unpack_shares(shares.y) > vec3f(0.0));
    let square = dot(up, up) + dot(down, down);
    if brick >= injected.count || square == 0.0 { return; }
    let flux = dot(up + down, vec3f(1.0)) * inverseSqrt(square) * vpl.flux;
    let moment = {{ 0.5 / pi }} * source.moment_scale * dot(flux, vec3f(1.0)) * way_to_light(index, vpl.position);
    let light_slot = 3u * (8u * brick + leaf.corner);
    let moment_slot = light_slot + 24u;
    {% for axis in "xyz" %}
    atomicAdd(&sums[light_slot + {{ loop.index0 }}u], u32(round(source.scale.{{ axis }} * flux.{{ axis }})));
    atomicAdd(&sums[moment_slot + {{ loop.index0 }}u], bitcast<u32>(i32(round(moment.{{ axis }}))));
    {% endfor %}
}
