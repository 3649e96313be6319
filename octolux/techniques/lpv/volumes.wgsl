// Accumulated light into one filterable texture a channel; still scaled for storage (storage_scale.wgsl).

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) cell: vec3u) {
    if any(cell >= textureDimensions(red_out)) { return; }
    let n = textureDimensions(red_out).x;
    let first = 3u * (cell.x + n * (cell.y + n * cell.z));
    textureStore(red_out, cell, light[first]);
    textureStore(green_out, cell, light[first + 1u]);
    textureStore(blue_out, cell, light[first + 2u]);
}
