// Irradiance of what the camera sees from the faces of the cells around it (simulator/lpv/gathering.py, `read_cube`), {% if corners %}as far
// as planes let through{% else %}of those
// that have been filled: others may lie in or behind walls, and would darken every corner{% endif %}.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/gbuffer.wgsl") }}
{{ use("techniques/lpv/storage_scale.wgsl") }}
{{ use("techniques/lpv/place.wgsl") }}
{% if windows > 1 %}
{{ use("shaders/blending.wgsl") }}
{% endif %}

{% if corners %}
{{ use("techniques/lpv/gathering/corners.wgsl") }}

fn read_cube(window: u32, seen: SeenPlace) -> vec3f {
    let corners = corners_at(window, place_in(window, seen));
    let squares = seen.normal * seen.normal;
    let faces = vec3u({{ n }}u) * (vec3u(0u, 2u, 4u) + select(vec3u(1u), vec3u(0u), seen.normal >= vec3f(0.0)));
    var sum = vec4f(0.0);
    {% for corner in range(8) %}
    {
        let at = corner_cell(corners.first, {{ corner }}u) + vec3u(0u, {{ n }}u * window, 0u);
        let light = {% for axis in "xyz" %}squares.{{ axis }} * textureLoad(cube, at + vec3u(0u, 0u, faces.{{ axis }}), 0){{ "" if loop.last else " + " }}{% endfor %};
        sum += corners.{{ "low" if corner < 4 else "high" }}[{{ corner % 4 }}] * light;
    }
    {% endfor %}
    let cell_size = grids[window].cell_size; // the weights' sum is 1, unless rounding has asked for other cells
    return sum.rgb / (max(sum.a, {{ least }}) * cell_size * cell_size);
}
{% else %}
fn read_cube(window: u32, seen: SeenPlace) -> vec3f {
    let place = clamp(place_in(window, seen), vec3f(0.5), vec3f({{ n - 0.5 }})); // windows and faces lie behind one another
    var irradiance = vec3f(0.0);
    {% for axis in "xyz" %}
    {
        let face = select({{ 2 * loop.index0 + 1 }}.0, {{ 2 * loop.index0 }}.0, seen.normal.{{ axis }} >= 0.0);
        let at = (place + {{ n }}.0 * vec3f(0.0, f32(window), face)) * vec3f({{ 1 / n }}, {{ 1 / (n * windows) }}, {{ 1 / (6 * n) }});
        let light = textureSampleLevel(cube, volume_sampler, at, 0.0);
        irradiance += seen.normal.{{ axis }} * seen.normal.{{ axis }} * light.rgb / max(light.a, {{ least }});
    }
    {% endfor %}
    let cell_size = grids[window].cell_size;
    return irradiance / (cell_size * cell_size);
}
{% endif %}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) pixel: vec3u) {
    if any(pixel.xy >= textureDimensions(depth_map)) { return; }
    let seen = seen_place(pixel.xy);
    if !seen.inside {
        textureStore(irradiance_out, pixel.xy, vec4f(0.0, 0.0, 0.0, 1.0));
        return;
    }
    let reading = finest_reading(seen);
    var irradiance = read_cube(reading.window, seen);
    {% if windows > 1 %}
    let next = read_cube(min(reading.window + 1u, {{ windows - 1 }}u), seen);
    irradiance = mix(next, irradiance, moved_share(dot(irradiance, vec3f(1.0)), dot(next, vec3f(1.0)), reading.share));
    {% endif %}
    let visible = {{ "textureLoad(visibility_map, pixel.xy, 0).x" if visibility else "1.0" }};
    textureStore(irradiance_out, pixel.xy, vec4f(irradiance * (1.0 / storage_scale(peak[0])), visible));
}
