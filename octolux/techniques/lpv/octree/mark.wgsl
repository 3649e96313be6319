// Marks the cells that surfaces are looked up in: their middles are on the surfaces' free side.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/gbuffer.wgsl") }}
{{ use("techniques/lpv/octree/place.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) pixel: vec3u) {
    if any(pixel.xy >= textureDimensions(depth_map)) { return; }
    let seen = seen_place(pixel.xy);
    if !seen.inside { return; }
    let cell = vec3u(clamp(seen.place, vec3f(0.0), vec3f({{ n - 1 }}.0)));
    let number = cell.x + {{ n }}u * (cell.y + {{ n }}u * cell.z);
    if atomicLoad(&marks[number]) == 0u { atomicStore(&marks[number], 1u); }
}
