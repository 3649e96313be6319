// Light of voxels of level 0 and its moment: as injected, and what they reflect of what the coarse voxels around them receive
// on six sides (receive.wgsl), as axial/reflect.wgsl. The mean of the ways to where a side's light comes from, by the cosine,
// is 2/3 of the side's.
{{ use("techniques/voxel_cones/octree/octree.wgsl") }}
{{ use("techniques/voxel_cones/bricks/facing.wgsl") }}
{{ use("techniques/voxel_cones/voxels/voxel.wgsl") }}
{{ use("techniques/voxel_cones/lobes/moment.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + {{ row }}u * id.y;
    if index >= 8u * bounce.count { return; }
    let place = 8u * bounce.first + index;
    let owner = owners[place >> 3u];
    if (owner & 7u) == 2u { return; }
    let corner = index & 7u;
    let node = owner >> 3u;
    let code = (8u * codes[node] + corner) >> {{ 3 * level }}u; // of the coarse voxel
    let coarse = node_of(code >> 3u);
    let leaf = load_leaves(node - bounce.first_leaf);
    let there = ((leaf >> corner) & 1u) == 1u && coarse != NO_NODE;
    let first = 16u * (brick_of_way(ways[select(0u, coarse, there)], 0u) - bounce.coarse_first) + (code & 7u);
    let voxel = unpack_surface(load_voxels((leaf >> 8u) + countOneBits(leaf & ((1u << corner) - 1u))));
    let packed = facing[8u * node + corner];
    let shares = array<vec3f, 2>(unpack_shares(packed.x), unpack_shares(packed.y));
    var reflected = vec3f(0.0);
    var moment = vec3f(0.0);
    {% for number, axis in ((0, "x"), (1, "y"), (2, "z")) %}{% for side in range(2) %}
    {
        let arriving = unpack_bright(received[select(0u, first + {{ 16 * number + 8 * side }}u, there)]);
        let sent = shares[{{ side }}].{{ axis }} * voxel.albedo * arriving;
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
