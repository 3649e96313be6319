// Marks the lower corner of each eight cells that a pixel's lookup filters.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/gbuffer.wgsl") }}
{{ use("techniques/lpv/octree/place.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) pixel: vec3u) {
    if any(pixel.xy >= textureDimensions(depth_map)) { return; }
    let seen = seen_place(pixel.xy);
    if !seen.inside { return; }
    let corner = vec3u(filtered_place(seen.place));
    let number = corner.x + {{ n }}u * (corner.y + {{ n }}u * corner.z);
    if atomicLoad(&corners[number]) == 0u { atomicStore(&corners[number], 1u); }
}
