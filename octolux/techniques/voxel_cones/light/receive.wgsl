// What surfaces that face one way in a coarse voxel receive through wide cones, over pi: as shares of a unit (bright.wgsl). A
// thread for each of the eight voxels of a brick's node, and each of the brick's {{ sides }} sides. Cones start off the
// voxel's face, where nothing in it is before them.
{{ use("shaders/sample_directions.wgsl") }}
{{ use("techniques/voxel_cones/cones/wide_cone.wgsl") }}
{{ use("techniques/voxel_cones/bricks/facing.wgsl") }}
{{ use("techniques/voxel_cones/bricks/bright.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + {{ row }}u * id.y;
    if index >= {{ 8 * sides }}u * bounce.coarse_count { return; }
    let owner = owners[bounce.coarse_first + index / {{ 8 * sides }}u];
    let corner = index & 7u;
    let way = {{ sides }}u * (owner & 7u) + (index >> 3u) % {{ sides }}u;
    let wanted = share_of_way(facing[8u * (owner >> 3u) + corner], way) > 0.0;
    let cell = cell_of(8u * codes[owner >> 3u] + corner);
    let side = select(1.0, -1.0, (way & 1u) == 1u);
    let normal = side * select(select(vec3f(0.0, 0.0, 1.0), vec3f(0.0, 1.0, 0.0), (way >> 1u) == 1u), vec3f(1.0, 0.0, 0.0), way < 2u);
    let start = {{ 2**level }}.0 * (vec3f(cell) + 0.5) + {{ 0.5 * 2**level + offset }} * normal;
    let shift = phase_shift((cell.x & 3u) | (((cell.y ^ cell.z) & 3u) << 2u));
    let basis = basis_of(normal);
    var sum = vec3f(0.0);
    for (var i = 0u; i < {{ cones }}u; i++) {
        sum += wide_cone(start, from_basis(basis, cone_axis(i, shift)), normal, 0.0, wanted).radiance;
    }
    received[bounce.now + index] = pack_bright({{ 1 / cones }} * bounce.per_unit * sum);
}
