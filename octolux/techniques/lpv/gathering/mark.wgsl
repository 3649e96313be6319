// Marks the cells that surfaces are looked up in: their middles are on the surfaces' free side.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/gbuffer.wgsl") }}
{{ use("techniques/lpv/place.wgsl") }}

fn mark(window: u32, seen: SeenPlace) {
    let cell = vec3u(clamp(place_in(window, seen), vec3f(0.0), vec3f({{ n - 1 }}.0)));
    let number = {{ n**3 }}u * window + cell.x + {{ n }}u * (cell.y + {{ n }}u * cell.z);
    if atomicLoad(&marks[number]) == 0u { atomicStore(&marks[number], 1u); }
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) pixel: vec3u) {
    if any(pixel.xy >= textureDimensions(depth_map)) { return; }
    let seen = seen_place(pixel.xy);
    if !seen.inside { return; }
    let reading = finest_reading(seen);
    mark(reading.window, seen);
    {% if windows > 1 %}
    if reading.share < 1.0 { mark(reading.window + 1u, seen); }
    {% endif %}
}
