// Light of a voxel, and its moment, from those of the eight voxels that one child of its node owns (simulator/voxels/lobes.py,
// `coarser_light`). A node's first brick does it for all.
{{ use("techniques/voxel_cones/bricks/facing.wgsl") }}
{{ use("techniques/voxel_cones/bricks/bright.wgsl") }}
{{ use("techniques/voxel_cones/lobes/moment.wgsl") }}

// Of a voxel all that faces either way along any axis.
fn sections(packed: vec2u) -> f32 { return dot(unpack_shares(packed.x) + unpack_shares(packed.y), vec3f(1.0)); }

fn coarser_light(node: u32, brick: u32, way: u32, corner: u32, child: u32) {
    if way != 0u { return; }
    let first = 8u * brick_of_way(ways[child], 0u);
    var sum = vec3f(0.0);
    var moment = vec3f(0.0);
    var weight = 0.0;
    for (var k = 0u; k < 8u; k++) {
        sum += unpack_bright(light[first + k]);
        moment += unpack_moment(light[first + 8u + k]);
        weight += sections(facing[8u * child + k]);
    }
    let share = sections(facing[8u * node + corner]) / max(weight, 1e-9);
    light[8u * brick + corner] = pack_bright(share * sum);
    light[8u * brick + 8u + corner] = pack_moment(share * moment);
}
