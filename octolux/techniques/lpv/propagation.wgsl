// One propagation step (CLPV 3.3; variants and their derivation: simulator/lpv/propagation.py).
//
// A step has 30 faces a cell, but their lobes share few directions: flux is summed into one total and one vector for each
// channel and made a lobe once. Loads and stores are what the step costs on a CPU. So a thread does {{ block|join(" x ") }} cells,
// which share neighbours; and the sum is only touched in every second step, which then adds what it has read of its own
// cells besides what it makes of them (`adds` says how many terms).

{{ use("techniques/lpv/cells.wgsl") }}

{% set step = macros("techniques/lpv/receive.wgsl") %}
{# What the geometry volume lets through the face of cell `key` at the upper or lower end of `axis`, to light along `travel`. #}
{% macro passing(key, axis, upper, travel) %}{% if occluded %}passes_{{ key }}_{{ axis }}{{ upper|int }}.{{ travel }} * {% endif %}{% endmacro %}

{% macro beside(offset, row, slab) %}{{ 3 * offset[0] }} + {{ offset[1] }} * {{ row }} + {{ offset[2] }} * {{ slab }}{% endmacro %}

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
    {% if adds %}
    let light_row = 3 * level.n;
    let light_slab = light_row * level.n;
    let light_here = i32(light_index(level, base, 0u));
    {% endif %}
    {% for cell in block_cells if marks and adds %}
    var largest_{{ loop.index0 }} = 0.0;
    {% endfor %}
    {% for cell in block_cells if occluded %}
    {% set key = loop.index0 %}
    {% for axis in range(3) %}
    {% for upper in range(2) %}
    let passes_{{ key }}_{{ "xyz"[axis] }}{{ upper }} = faces[
        stored_index(level, base + vec3i({{ cell|join(", ") }}){% if upper %} + vec3i({{ unit[axis] }}){% endif %}, 0u) + {{ axis }}u].xyz;
    {% endfor %}
    {% endfor %}
    {% endfor %}
    for (var channel = 0u; channel < 3u; channel++) {
        {% for cell in block_cells %}
        var total_{{ loop.index0 }} = 0.0;
        var vector_{{ loop.index0 }} = vec3f(0.0);
        {% endfor %}
        {% for cell in block_cells if adds == 2 %}
        var former_{{ loop.index0 }}: vec4f;
        {% endfor %}
        {% for source in sources %}
        {
            let e = load_at(u32(here + i32(channel) + {{ beside(source.offset, "row", "slab") }}));
            {% for use in source.uses %}
            {{ step.receive(use.cell, use.axis, use.sign, passing) }}
            {% endfor %}
            {% if adds == 2 and source.own is not none %}
            former_{{ source.own }} = from_emission(e);
            {% endif %}
        }
        {% endfor %}
        {% for cell in block_cells %}
        {
            let c = vec4f({{ lobe0 }} * total_{{ loop.index0 }}, {{ lobe1 }} * vector_{{ loop.index0 }}.yzx);
            {% if adds %}
            light[u32(light_here + i32(channel) + {{ beside(cell, "light_row", "light_slab") }})] += c{% if adds == 2 %} + former_{{ loop.index0 }}{% endif %};
            {% endif %}
            {% if adds and marks %}
            largest_{{ loop.index0 }} = max(largest_{{ loop.index0 }}, {% if adds == 2 %}max(c.x, former_{{ loop.index0 }}.x){% else %}c.x{% endif %});
            {% endif %}
            store_at(u32(here + i32(channel) + {{ beside(cell, "row", "slab") }}), to_emission(c));
        }
        {% endfor %}
    }
    {% for cell in block_cells if marks and adds %}
    // I_i = i where a step brought light (OLPV 4.2, propagation)
    if largest_{{ loop.index0 }} > {{ threshold }} {
        touched[light_index(level, base + vec3i({{ cell|join(", ") }}), 0u) / 3u] = 1u;
    }
    {% endfor %}
}
