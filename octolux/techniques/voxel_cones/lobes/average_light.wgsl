// Light of the voxels of a node, and its moment, from those of its children (simulator/voxels/lobes.py, `coarser_light`): a
// thread for each of the eight voxels of a brick's node, of which those of the first brick do it.
{{ use("techniques/voxel_cones/octree.wgsl") }}
{{ use("techniques/voxel_cones/facing.wgsl") }}
{{ use("techniques/voxel_cones/bright.wgsl") }}
{{ use("techniques/voxel_cones/lobes/moment.wgsl") }}

// Of a voxel all that faces either way along any axis.
fn sections(packed: vec2u) -> f32 { return dot(unpack_shares(packed.x) + unpack_shares(packed.y), vec3f(1.0)); }

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = 8u * parameters.first + id.x + {{ row }}u * id.y;
    if index >= 8u * (parameters.first + parameters.count) { return; }
    let owner = owners[index >> 3u];
    {% if listed %}
    if touched[owner >> 3u] == 0u { return; }
    {% endif %}
    if (owner & 7u) != 0u { return; }
    let child = node_of(8u * codes[owner >> 3u] + (index & 7u));
    if child == NO_NODE { return; }
    let first = 8u * brick_of_way(ways[child], 0u);
    var sum = vec3f(0.0);
    var moment = vec3f(0.0);
    var weight = 0.0;
    for (var k = 0u; k < 8u; k++) {
        sum += unpack_bright(light[first + k]);
        moment += unpack_moment(light[first + 8u + k]);
        weight += sections(facing[8u * child + k]);
    }
    let share = sections(facing[8u * (owner >> 3u) + (index & 7u)]) / max(weight, 1e-9);
    light[index] = pack_bright(share * sum);
    light[index + 8u] = pack_moment(share * moment);
}
