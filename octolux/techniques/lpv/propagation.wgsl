// One propagation step (CLPV 3.3; variants and their derivation: simulator/lpv/propagation.py).
//
// A step has 30 faces a cell, but their lobes share few directions: flux is summed into one total and one vector for each
// channel and made a lobe once. Loads and stores are what the step costs on a CPU. So a thread does {{ block|join(" x ") }} cells,
// which share neighbours; and the sum is only touched in every second step, which then adds what it has read of its own
// cells besides what it makes of them. The first step reads injected light itself; the sum begins with it in the first or
// the second. `adds` says how many terms a step adds to the sum: none, two, or three with the injected light.

{{ use("techniques/lpv/cells.wgsl") }}
{{ use("techniques/lpv/thousandths.wgsl") }}

{% set step = macros("techniques/lpv/receive.wgsl") %}
{# What the geometry volume lets through the face of cell `key` at the upper or lower end of `axis`, to light along `travel`. #}
{% macro passing(key, axis, upper, travel) %}{% if occluded %}{{ face_names[key][axis][upper|int] }}.{{ travel }} * {% endif %}{% endmacro %}

{% macro across(key, axis, upper, travel) %}across_{{ face_names[key][axis][upper|int] }}.{{ travel }}{% endmacro %}
{% macro straight(key, upper) %}vec3f({% for axis in "xyz" %}{{ "" if loop.first else ", " }}straight_{{ face_names[key][axis][upper|int] }}{% endfor %}){% endmacro %}

{# What injected light at `offset` counts: nothing outside the volume, where no light is stored. #}
{% macro scale_at(offset) %}scale{% for k in range(3) if offset[k] < 0 or offset[k] >= block[k] %}_{{ "xyz"[k] }}{{ (offset[k] > 0)|int }}{% endfor %}{% endmacro %}

{% set begins = adds == 3 or first and adds %}

{% macro beside(offset, row, slab) %}{{ 3 * offset[0] }} + {{ offset[1] }} * {{ row }} + {{ offset[2] }} * {{ slab }}{% endmacro %}

{% macro beside_light(cell) %}{{ cell[0] }} + level.n * ({{ cell[1] }} + level.n * {{ cell[2] }}){% endmacro %}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let thread = thread_of(id);
    let level = level_of(thread);
    let number = thread - level.first;
    let blocks = vec3u(u32(level.n)) / vec3u({{ block|join("u, ") }}u);
    if number >= blocks.x * blocks.y * blocks.z { return; }
    let block = vec3u(number % blocks.x, (number / blocks.x) % blocks.y, number / (blocks.x * blocks.y));
    let base = vec3i(block) * vec3i({{ block|join(", ") }});
    // Where the block's lower cell lies, and how far its neighbours in y and z are.
    let row = 3 * (level.n + 2);
    let slab = row * (level.n + 2);
    let here = i32(stored_index(level, base, 0u));
    {% if adds or first or bounces != "none" %}
    let cell_here = level.light + base.x + level.n * (base.y + level.n * base.z);
    let light_row = 3 * level.n;
    let light_slab = light_row * level.n;
    let light_here = 3 * cell_here;
    {% endif %}
    {% if first or begins %}
    let scale = storage_scale(peak[0]);
    {% endif %}
    {% for axis in range(3) if first %}
    let scale_{{ "xyz"[axis] }}0 = select(0.0, scale, base.{{ "xyz"[axis] }} > 0);
    let scale_{{ "xyz"[axis] }}1 = select(0.0, scale, base.{{ "xyz"[axis] }} + {{ block[axis] }} < level.n);
    {% endfor %}
    {% for cell in block_cells if marks and adds %}
    var largest_{{ loop.index0 }} = 0.0;
    {% endfor %}
    {% for face in faces_met if occluded %}
    let {{ face.name }} = unpack_thousandths(faces[stored_index(level, base + vec3i({{ face.cell|join(", ") }}), 0u) + {{ face.axis }}u]);
    {% if bounces != "none" %}
    // Blocked by surfaces across the face's own axis, and by those across the way of the light (bounces.py, `reflected`).
    let straight_{{ face.name }} = {{ 5 ** -0.5 }} * (1.0 - {{ face.name }}.{{ "xyz"[face.axis] }});
    let across_{{ face.name }} = vec3f(1.0 - straight_{{ face.name }}) - {{ face.name }};
    {% endif %}
    {% endfor %}
    {% for cell in block_cells if bounces == "mono" %}
    let reflectance_{{ loop.index0 }} = reflectances[cell_here + {{ beside_light(cell) }}];
    let reflects_up_{{ loop.index0 }} = unpack_thousandths(reflectance_{{ loop.index0 }}.x);
    let reflects_down_{{ loop.index0 }} = unpack_thousandths(reflectance_{{ loop.index0 }}.y);
    {% endfor %}
    for (var channel = 0u; channel < 3u; channel++) {
        {% for cell in block_cells %}
        {% set key = loop.index0 %}
        var total_{{ key }} = 0.0;
        var vector_{{ key }} = vec3f(0.0);
        {% if bounces != "none" %}
        {% for way in ("up", "down") %}
        var back_{{ way }}_{{ key }} = vec3f(0.0); // blocked by surfaces across the way of the light
        var slanted_{{ way }}_{{ key }} = vec3f(0.0); // at faces, from the side
        {% endfor %}
        {% endif %}
        {% endfor %}
        {% for cell in block_cells if adds %}
        var former_{{ loop.index0 }}: vec4f;
        {% endfor %}
        {% for source in sources %}
        {
            {% if first %}
            let c = {{ scale_at(source.offset) }} * injected[u32(light_here + i32(channel) + {{ beside(source.offset, "light_row", "light_slab") }})];
            let e = to_emission(c);
            {% else %}
            let e = load_at(u32(here + i32(channel) + {{ beside(source.offset, "row", "slab") }}));
            {% endif %}
            {% for use in source.uses %}
            {{ step.receive(use.cell, use.axis, use.sign, passing, across if bounces != "none" else none) }}
            {% endfor %}
            {% if adds and source.own is not none %}
            former_{{ source.own }} = {% if first %}c{% else %}from_emission(e){% endif %};
            {% endif %}
        }
        {% endfor %}
        {% for cell in block_cells %}
        {% set key = loop.index0 %}
        {
            {% if bounces != "none" %}
            {% if bounces == "spectral" %}
            let reflectance = reflectances[3u * u32(cell_here + {{ beside_light(cell) }}) + channel];
            let reflects_up_{{ key }} = unpack_thousandths(reflectance.x);
            let reflects_down_{{ key }} = unpack_thousandths(reflectance.y);
            {% endif %}
            let up = (back_up_{{ key }} + slanted_up_{{ key }} * {{ straight(key, true) }}) * reflects_up_{{ key }};
            let down = (back_down_{{ key }} + slanted_down_{{ key }} * {{ straight(key, false) }}) * reflects_down_{{ key }};
            total_{{ key }} += dot(up + down, vec3f(1.0));
            vector_{{ key }} += down - up;
            {% endif %}
            let c = vec4f({{ lobe0 }} * total_{{ key }}, {{ lobe1 }} * vector_{{ key }}.yzx);
            {% if adds %}
            let number = u32(light_here + i32(channel) + {{ beside(cell, "light_row", "light_slab") }});
            let terms = c + former_{{ key }};
            {% if adds == 3 %}
            let start = scale * injected[number];
            light[number] = start + terms;
            {% else %}
            light[number] {{ "=" if begins else "+=" }} terms;
            {% endif %}
            {% if marks %}
            largest_{{ key }} = max(largest_{{ key }}, max({{ "max(start.x, c.x)" if adds == 3 else "c.x" }}, former_{{ key }}.x));
            {% endif %}
            {% endif %}
            {% if "store" in access %}
            store_at(u32(here + i32(channel) + {{ beside(cell, "row", "slab") }}), to_emission(c));
            {% endif %}
        }
        {% endfor %}
    }
    {% for cell in block_cells if marks and adds %}
    {% set mark = "touched[u32(cell_here + %d + level.n * (%d + level.n * %d))]"|format(*cell) %}
    {% if begins %}
    // I_i = i where light was injected, downsampled or brought (OLPV 4.2); other entries stay at l - 1, which is 0 here.
    {{ mark }} = select(0u, 1u, largest_{{ loop.index0 }} > {{ threshold }});
    {% else %}
    if largest_{{ loop.index0 }} > {{ threshold }} { {{ mark }} = 1u; }
    {% endif %}
    {% endfor %}
}
