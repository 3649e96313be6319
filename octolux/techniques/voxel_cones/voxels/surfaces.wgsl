// From sums to voxels, and to what faces each way on level 0: a thread for each of the eight that a node owns.
{{ use("techniques/voxel_cones/voxels/voxel.wgsl") }}
{{ use("techniques/voxel_cones/bricks/facing.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + {{ row }}u * id.y;
    if index >= 8u * parameters.count { return; }
    let leaf = load_leaves(index >> 3u);
    let corner = index & 7u;
    let slot = (leaf >> 8u) + countOneBits(leaf & ((1u << corner) - 1u)) - cube.first;
    if ((leaf >> corner) & 1u) == 0u || slot >= cube.room { return; }
    let first = {{ words }}u * slot;
    let unit = {{ 1 / layer }};
    let up = min(vec3f(f32(sums[first]), f32(sums[first + 2u]), f32(sums[first + 4u])) * unit, vec3f(1.0));
    let down = min(vec3f(f32(sums[first + 1u]), f32(sums[first + 3u]), f32(sums[first + 5u])) * unit, vec3f(1.0));
    let over = 1.0 / max(f32(sums[first + 9u]), 1.0);
    let albedo = vec3f(f32(sums[first + 6u]), f32(sums[first + 7u]), f32(sums[first + 8u])) * over;
    var emission = vec3f(0.0);
    {% if emissive %}
    emission = vec3f(f32(sums[first + 10u]), f32(sums[first + 11u]), f32(sums[first + 12u])) * over * {{ layer / emission_layer }};
    {% endif %}
    store_voxels(slot + cube.first, pack_surface(VoxelSurface(saturate(albedo), up, down, emission)));
    facing[8u * parameters.first + index] = vec2u(pack_shares(up), pack_shares(down));
}
