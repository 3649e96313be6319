// Light that the voxels of a node send one way from that of its children (simulator/voxels/pyramid.py, coarser_intensity):
// a thread for each of the eight voxels of a brick's node. What is behind counts for what the voxel in front lets through. What
// faces so little of the way that it is nothing sends nothing.
{{ use("techniques/voxel_cones/octree.wgsl") }}
{{ use("techniques/voxel_cones/facing.wgsl") }}
{{ use("techniques/voxel_cones/bright.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = 8u * parameters.first + id.x + {{ row }}u * id.y;
    if index >= 8u * (parameters.first + parameters.count) { return; }
    let owner = owners[index >> 3u];
    {% if listed %}
    if touched[owner >> 3u] == 0u { return; }
    {% endif %}
    let way = owner & 7u;
    let child = node_of(8u * codes[owner >> 3u] + (index & 7u));
    if child == NO_NODE { return; }
    let brick = brick_of_way(ways[child], way);
    if brick == NO_NODE { return; }
    let axis = way >> 1u;
    let along = 1u << axis;
    let first_across = select(1u, 2u, axis == 0u);
    let second_across = 7u - along - first_across;
    var sum = vec3f(0.0);
    for (var k = 0u; k < 4u; k++) {
        let lower = (k & 1u) * first_across + (k >> 1u) * second_across;
        let front = lower + select(0u, along, (way & 1u) == 0u);
        let behind = front ^ along;
        let in_front = share_of_way(facing[8u * child + front], way);
        let hidden = share_of_way(facing[8u * child + behind], way);
        let seen = in_front + (1.0 - in_front) * hidden;
        let light_seen = unpack_bright(light[8u * brick + front]) + (1.0 - in_front) * unpack_bright(light[8u * brick + behind]);
        sum += light_seen * (0.25 * max(in_front, hidden) / max(seen, 1e-9));
    }
    let faces = share_of_way(facing[8u * (owner >> 3u) + (index & 7u)], way) > 0.0;
    light[index] = pack_bright(select(vec3f(0.0), sum, faces));
}
