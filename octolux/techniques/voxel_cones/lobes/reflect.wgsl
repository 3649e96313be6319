// Light of voxels of level 0 and its moment: as injected, and what they reflect of what the coarse voxels around them receive
// on six sides (receive.wgsl), as axial/reflect.wgsl. The mean of the ways to where a side's light comes from, by the cosine,
// is 2/3 of the side's.
{{ use("techniques/voxel_cones/light/reflector.wgsl") }}
{{ use("techniques/voxel_cones/lobes/moment.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + {{ row }}u * id.y;
    if index >= 8u * bounce.count { return; }
    let place = 8u * bounce.first + index;
    let owner = owners[place >> 3u];
    if (owner & 7u) == 2u { return; }
    let voxel = reflector_at(owner >> 3u, index & 7u);
    let coarse = node_of(voxel.coarse >> 3u);
    let there = voxel.occupied && coarse != NO_NODE;
    let first = 16u * (brick_of_way(ways[select(0u, coarse, there)], 0u) - bounce.coarse_first) + (voxel.coarse & 7u);
    let shares = array<vec3f, 2>(unpack_shares(voxel.facing.x), unpack_shares(voxel.facing.y));
    var reflected = vec3f(0.0);
    var moment = vec3f(0.0);
    {% for number, axis in ((0, "x"), (1, "y"), (2, "z")) %}{% for side in range(2) %}
    {
        let arriving = arriving_at(select(0u, first + {{ 16 * number + 8 * side }}u, there));
        let sent = shares[{{ side }}].{{ axis }} * voxel.surface.albedo * arriving;
        reflected += sent;
        moment.{{ axis }} += {{ (2 - 4 * side) / 9 }} * dot(sent, vec3f(1.0));
    }
    {% endfor %}{% endfor %}
    let before = injected_light[index];
    if (owner & 7u) == 0u {
        light[place] = pack_bright(unpack_bright(before) + select(vec3f(0.0), reflected, there));
    } else {
        light[place] = pack_moment(unpack_moment(before) + select(vec3f(0.0), moment, there));
    }
}
