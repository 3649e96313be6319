// Light that a voxel sends one way from that of the eight voxels that one child of its node owns (simulator/voxels/pyramid.py,
// coarser_intensity). What is behind counts for what the voxel in front lets through; what faces so little of the way that it is
// nothing sends nothing.
{{ use("techniques/voxel_cones/bricks/facing.wgsl") }}
{{ use("techniques/voxel_cones/bricks/bright.wgsl") }}

// brick: of the voxel's node and the way.
fn coarser_light(node: u32, brick: u32, way: u32, corner: u32, child: u32) {
    let below = brick_of_way(ways[child], way);
    if below == NO_NODE { return; }
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
        let light_seen = unpack_bright(light[8u * below + front]) + (1.0 - in_front) * unpack_bright(light[8u * below + behind]);
        sum += light_seen * (0.25 * max(in_front, hidden) / max(seen, 1e-9));
    }
    let faces = share_of_way(facing[8u * node + corner], way) > 0.0;
    light[8u * brick + corner] = pack_bright(select(vec3f(0.0), sum, faces));
}
