// What the lower face of each cell across each axis lets through of light along x, y and z (simulator/lpv/geometry.py,
// `face_transmittance`): the blocked shares of the four cells of the geometry volume around it, which lies half a cell aside,
// so that eight of its cells meet at a cell's corners.{% if bounces != "none" %} And what those eight reflect (bounces.py, `cell_reflectance`).{% endif %}

// A word holds three numbers (thousandths.wgsl): a step loads less than a tenth of what its cells are. A thread does a block
// of cells, which share corners.
{{ use("techniques/lpv/cells.wgsl") }}
{{ use("techniques/lpv/thousandths.wgsl") }}

{% macro at(place) %}{{ place|join("") }}{% endmacro %}
{% macro beside(cell, corner) %}{{ cell[0] + corner[0] }}{{ cell[1] + corner[1] }}{{ cell[2] + corner[2] }}{% endmacro %}
{% if bounces != "none" %}
fn reflected_share(reflecting: vec3f, blocked: vec3f) -> vec3f {
    return select(vec3f(0.0), reflecting / blocked, blocked > vec3f(0.0));
}
{% endif %}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let thread = thread_of(id);
    let level = level_of(thread);
    let number = thread - level.first;
    let blocks = vec3u(u32(level.n + 2)) / vec3u({{ block|join("u, ") }}u); // there is a face beyond the last cell
    if number >= blocks.x * blocks.y * blocks.z { return; }
    let place = vec3u(number % blocks.x, (number / blocks.x) % blocks.y, number / (blocks.x * blocks.y));
    let base = vec3i(place) * vec3i({{ block|join(", ") }});
    {% for place in corners %}
    let place_{{ at(place) }} = base - vec3i(1) + vec3i({{ place|join(", ") }});
    let inside_{{ at(place) }} = all(place_{{ at(place) }} >= vec3i(0)) && all(place_{{ at(place) }} < vec3i(level.n));
    let from_{{ at(place) }} = select(0u, light_index(level, place_{{ at(place) }}, 0u) / 3u, inside_{{ at(place) }});
    let shares_{{ at(place) }} = select(vec3f(0.0), shares[from_{{ at(place) }}].xyz, inside_{{ at(place) }});
    {% if bounces != "none" %}
    let facing_xy_{{ at(place) }} = reflectors[3u * from_{{ at(place) }}];
    let facing_z_{{ at(place) }} = reflectors[3u * from_{{ at(place) }} + 1u];
    let albedo_{{ at(place) }} = min(reflectors[3u * from_{{ at(place) }} + 2u], vec4f(1.0));
    let up_{{ at(place) }} = min(vec3f(facing_xy_{{ at(place) }}.yw, facing_z_{{ at(place) }}.y), shares_{{ at(place) }});
    let down_{{ at(place) }} = min(vec3f(facing_xy_{{ at(place) }}.xz, facing_z_{{ at(place) }}.x), shares_{{ at(place) }});
    {% endif %}
    {% endfor %}
    {% for cell in block_cells %}
    {
        let cell = base + vec3i({{ cell|join(", ") }});
        if all(cell <= vec3i(level.n)) {
            {% for axis in range(3) %}
            {% set b, c = (axis + 1) % 3, (axis + 2) % 3 %}
            {
                let blocked = 0.25 * ({% for corner in cell_corners if not corner[axis] %}{{ "" if loop.first else " + " }}shares_{{ beside(cell, corner) }}{% endfor %});
                var way = vec3f(blocked.{{ "xyz"[axis] }});
                way.{{ "xyz"[b] }} = (2.0 * blocked.{{ "xyz"[b] }} + blocked.{{ "xyz"[axis] }}) * {{ 5 ** -0.5 }};
                way.{{ "xyz"[c] }} = (2.0 * blocked.{{ "xyz"[c] }} + blocked.{{ "xyz"[axis] }}) * {{ 5 ** -0.5 }};
                faces[stored_index(level, cell, 0u) + {{ axis }}u] = pack_thousandths(1.0 - min(way, vec3f(1.0)));
            }
            {% endfor %}
        }
        {% if bounces != "none" %}
        if all(cell < vec3i(level.n)) {
            let blocked = {% for corner in cell_corners %}{{ "" if loop.first else " + " }}shares_{{ beside(cell, corner) }}{% endfor %};
            let own = light_index(level, cell, 0u){% if bounces == "mono" %} / 3u{% endif %};
            {% for channel in ("rgb" if bounces == "spectral" else "a") %}
            {
                let up = {% for corner in cell_corners %}{{ "" if loop.first else " + " }}up_{{ beside(cell, corner) }} * albedo_{{ beside(cell, corner) }}.{{ channel }}{% endfor %};
                let down = {% for corner in cell_corners %}{{ "" if loop.first else " + " }}down_{{ beside(cell, corner) }} * albedo_{{ beside(cell, corner) }}.{{ channel }}{% endfor %};
                reflectances[own + {{ loop.index0 }}u] = vec2u(
                    pack_thousandths(reflected_share(up, blocked)), pack_thousandths(reflected_share(down, blocked)));
            }
            {% endfor %}
        }
        {% endif %}
    }
    {% endfor %}
}
