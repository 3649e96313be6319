// Baseline of the propagation step: what one writes first. One thread a cell gathers from its six neighbours; each of the 30
// faces is evaluated, clamped and reprojected by itself (CLPV 3.3), unrolled by the template, in f32.

fn cell_index(cell: vec3i) -> u32 { return u32(cell.x + {{ n }} * (cell.y + {{ n }} * cell.z)); }

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let cell = vec3i(id);
    if any(cell >= vec3i({{ n }})) { return; }
    var sum: array<vec4f, 3>;
    {% for travel in travels %}
    {
        let neighbour = cell - vec3i({{ travel.direction|join(", ") }});
        if all(neighbour >= vec3i(0)) && all(neighbour < vec3i({{ n }})) {
            let first = 3u * cell_index(neighbour);
            for (var channel = 0u; channel < 3u; channel++) {
                let c = cells_in[first + channel];
                var received = vec4f(0.0);
                {% for face in travel.faces %}
                received += max(0.0, dot(c, vec4f({{ face.weights|join(", ") }}))) * vec4f({{ face.lobe|join(", ") }});
                {% endfor %}
                sum[channel] += received;
            }
        }
    }
    {% endfor %}
    let first = 3u * cell_index(cell);
    for (var channel = 0u; channel < 3u; channel++) {
        cells_out[first + channel] = sum[channel];
        light[first + channel] += sum[channel];
    }
}
