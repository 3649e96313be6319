// What the lower face of each cell across each axis lets through of light along x, y and z (simulator/lpv/geometry.py,
// `face_transmittance`): the blocked shares of the four cells of the geometry volume around it, which lies half a cell aside.
// Three numbers of 10 bits make a word, so that a step loads a ninth of the bytes of cells (simulator/lpv/formats.py).
{{ use("techniques/lpv/cells.wgsl") }}
{{ use("techniques/lpv/thousandths.wgsl") }}

fn shares_at(level: Level, cell: vec3i) -> vec3f {
    if any(cell < vec3i(0)) || any(cell >= vec3i(level.n)) { return vec3f(0.0); }
    return shares[light_index(level, cell, 0u) / 3u].xyz;
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let thread = thread_of(id);
    let level = level_of(thread);
    let number = thread - level.first;
    let edge = level.n + 1; // a face beyond the last cell
    if number >= u32(edge * edge * edge) { return; }
    let cell = cell_of(number, edge);
    {% for axis in range(3) %}
    {% set a, b, c = axis, (axis + 1) % 3, (axis + 2) % 3 %}
    {
        let corner = cell - vec3i(1);
        let along_b = vec3i({{ unit[b] }});
        let along_c = vec3i({{ unit[c] }});
        let blocked = 0.25 * (shares_at(level, corner) + shares_at(level, corner + along_b)
            + shares_at(level, corner + along_c) + shares_at(level, corner + along_b + along_c));
        var way = vec3f(blocked.{{ "xyz"[a] }});
        way.{{ "xyz"[b] }} = (2.0 * blocked.{{ "xyz"[b] }} + blocked.{{ "xyz"[a] }}) * {{ 5 ** -0.5 }};
        way.{{ "xyz"[c] }} = (2.0 * blocked.{{ "xyz"[c] }} + blocked.{{ "xyz"[a] }}) * {{ 5 ** -0.5 }};
        faces[stored_index(level, cell, 0u) + {{ axis }}u] = pack_thousandths(1.0 - min(way, vec3f(1.0)));
    }
    {% endfor %}
}
