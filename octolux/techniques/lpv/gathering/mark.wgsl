// Marks the cells that surfaces are looked up in: {% if corners %}all around that count{% else %}their middles are on the surfaces' free side{% endif %}.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/gbuffer.wgsl") }}
{{ use("techniques/lpv/place.wgsl") }}

{% if corners %}{{ use("techniques/lpv/gathering/corners.wgsl") }}{% endif %}

fn mark_cell(window: u32, cell: vec3u) {
    let number = {{ n**3 }}u * window + cell.x + {{ n }}u * (cell.y + {{ n }}u * cell.z);
    if atomicLoad(&marks[number]) == 0u { atomicStore(&marks[number], 1u); }
}

fn mark(window: u32, seen: SeenPlace) {
    {% if corners %}
    let corners = corners_at(window, place_in(window, seen));
    {% for corner in range(8) %}
    if corners.{{ "low" if corner < 4 else "high" }}[{{ corner % 4 }}] > 0.0 { mark_cell(window, corner_cell(corners.first, {{ corner }}u)); }
    {% endfor %}
    {% else %}
    mark_cell(window, vec3u(clamp(place_in(window, seen), vec3f(0.0), vec3f({{ n - 1 }}.0))));
    {% endif %}
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
