// One step of all leaves (simulator/lpv/sparse.py): each asks the leaves at its six sides. There is one of the same size,
// or a larger one, of whose flux into what it sees as its neighbour a child takes its share; or four smaller ones.
{{ use("techniques/lpv/cells.wgsl") }}
{{ use("techniques/lpv/octree/sparse_nodes.wgsl") }}

{% set step = macros("techniques/lpv/receive.wgsl") %}
{% macro share(key, axis, upper, travel) %}{{ "far" if axis == travel else (axis ~ "_" ~ upper|int) }}_share * {% endmacro %}

// Leaves at a side: `count` of them, 1 or 4, from `slot` on. larger: it is one of the next level.
struct Beside { slot: u32, count: u32, larger: bool }

// `cell` of `level` is inside the volume. near: added to a brick's first slot, its child at the side that faces us.
fn beside(level: u32, cell: vec3u, near: u32) -> Beside {
    let parent = cell >> vec3u(1u);
    let siblings = children_of(level + 1u, parent);
    if siblings == 0u { return Beside(slot_in(children_of(level + 2u, parent >> vec3u(1u)), parent), 1u, true); }
    let children = children_of(level, cell);
    if children == 0u { return Beside(slot_in(siblings, cell), 1u, false); }
    return Beside(8u * (children - 1u) + near, 4u, false);
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let slot = thread_of(id);
    if slot >= 8u * count[0] { return; }
    let node = node_of(slot);
    if children_of(node.level, node.cell) != 0u { return; }
    let edge = i32(edge_of(node.level));
    let upper = vec3f(node.cell & vec3u(1u)); // in its parent
    {% for channel in range(3) %}
    var total_{{ channel }} = 0.0;
    var vector_{{ channel }} = vec3f(0.0);
    {% endfor %}
    {% for travel in directions %}
    {
        let from_cell = vec3i(node.cell) - vec3i({{ travel.direction|join(", ") }});
        if from_cell.{{ travel.axis }} >= 0 && from_cell.{{ travel.axis }} < edge {
            let source = beside(node.level, vec3u(from_cell), {{ travel.near }}u);
            let far_share = select(1.0, 0.25, source.larger);
            {% for other in travel.others %}
            let {{ other }}_1_share = select(1.0, 0.5 * upper.{{ other }}, source.larger);
            let {{ other }}_0_share = select(1.0, 0.5 - 0.5 * upper.{{ other }}, source.larger);
            {% endfor %}
            for (var k = 0u; k < source.count; k++) {
                let at = source.slot + {{ travel.strides[0] }}u * (k & 1u) + {{ travel.strides[1] }}u * (k >> 1u);
                {% for channel in range(3) %}
                {
                    let e = load_at(3u * at + {{ channel }}u);
                    {{ step.receive(channel, travel.axis, travel.sign, share) }}
                }
                {% endfor %}
            }
        }
    }
    {% endfor %}
    {% for channel in range(3) %}
    {
        let c = vec4f({{ lobe0 }} * total_{{ channel }}, {{ lobe1 }} * vector_{{ channel }}.yzx);
        light[3u * slot + {{ channel }}u] += c;
        store_at(3u * slot + {{ channel }}u, to_emission(c));
    }
    {% endfor %}
}
