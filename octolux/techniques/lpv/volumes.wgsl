// Accumulated light into one filterable texture a channel; still scaled for storage (storage_scale.wgsl). Windows, whose
// cells lie behind one another, are laid behind one another in y.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) texel: vec3u) {
    if any(texel >= textureDimensions(red_out)) { return; }
    let slab = {{ n }}u * (texel.y / {{ n }}u) + texel.z;
    let first = 3u * (texel.x + {{ n }}u * (texel.y % {{ n }}u + {{ n }}u * slab));
    textureStore(red_out, texel, light[first]);
    textureStore(green_out, texel, light[first + 1u]);
    textureStore(blue_out, texel, light[first + 2u]);
}
