// Test kernel: the traits of each pixel, and what comes out of them again.
{{ use("shaders/pixel_traits.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(id_map);
    if any(id.xy >= size) { return; }
    let packed = pixel_traits(id.xy);
    let traits = unpack_traits(packed);
    let i = 6u * (id.y * size.x + id.x);
    result[i] = packed;
    for (var k = 0u; k < 3u; k++) { result[i + 1u + k] = bitcast<u32>(traits.albedo[k]); }
    result[i + 4u] = bitcast<u32>(traits.size);
    result[i + 5u] = u32(traits.moving);
}
