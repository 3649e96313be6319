// Shares of sections at points (x, y, z) in voxels of level 0, at a level: six numbers, and 1 where there is a node.
{{ use("techniques/voxel_cones/octree.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= {{ count }}u { return; }
    let level = u32(given[id.x].w);
    let place = place_at(level, given[id.x].xyz / f32(1u << level));
    let at = place.texel / vec3f(textureDimensions(bricks_up));
    let up = textureSampleLevel(bricks_up, linear, at, 0.0).xyz;
    let down = textureSampleLevel(bricks_down, linear, at, 0.0).xyz;
    let found = select(0.0, 1.0, place.found);
    result[2u * id.x] = found * vec4f(up.x, down.x, up.y, down.y);
    result[2u * id.x + 1u] = found * vec4f(up.z, down.z, 1.0, 0.0);
}
