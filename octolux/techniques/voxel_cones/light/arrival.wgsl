// Where the flux of a VPL arrives: the voxel that its point lies in, and which ways this sends it.
{{ use("shaders/octahedral.wgsl") }}
{{ use("techniques/voxel_cones/octree/leaves.wgsl") }}
{{ use("techniques/voxel_cones/bricks/facing.wgsl") }}

// node, corner: of level 0, and which of its voxels.  up, down: how far the VPL's normal points each way that the voxel faces.
// square: sum of their squares; 0 where nothing arrives.
struct Arrival { node: u32, corner: u32, up: vec3f, down: vec3f, square: f32 }

fn arrival_of(vpl: Vpl) -> Arrival {
    let normal = unpack_unit_vector(vpl.normal);
    let leaf = leaf_of_surface(to_voxels(vpl.position), normal);
    if leaf.node == NO_NODE || all(vpl.flux == vec3f(0.0)) { return Arrival(0u, 0u, vec3f(0.0), vec3f(0.0), 0.0); }
    let shares = facing[8u * leaf.node + leaf.corner];
    let up = select(vec3f(0.0), max(normal, vec3f(0.0)), unpack_shares(shares.x) > vec3f(0.0));
    let down = select(vec3f(0.0), max(-normal, vec3f(0.0)), unpack_shares(shares.y) > vec3f(0.0));
    return Arrival(leaf.node, leaf.corner, up, down, dot(up, up) + dot(down, down));
}
