// How many tiles of columns each triangle has.
{{ use("raytracing/world_triangle.wgsl") }}
{{ use("techniques/voxel_cones/voxels/fragments.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + {{ row }}u * id.y;
    if index >= parameters.count { return; }
    let t = world_triangle(load_ids(index));
    let tiles = tiles_of(columns_of(projected(to_voxels(t.a), to_voxels(t.b), to_voxels(t.c))));
    values[index] = tiles.x * tiles.y;
}
