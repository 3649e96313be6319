// Downsampling (OLPV 4.2, eq. 11): each parent from its eight children, up to three levels in one dispatch. A workgroup
// makes 4 x 4 x 4 parents of the first level, from which it goes on in its own memory if there are more.
// Cells have {{ per_cell }} numbers of four; levels lie behind one another in `cells`.

{% if levels|length > 2 %}
var<workgroup> parents: array<vec4f, {{ 64 * per_cell }}>;
var<workgroup> grandparents: array<vec4f, {{ 8 * per_cell }}>;
{% endif %}

fn combined(sum: vec4f) -> vec4f {
    return {% if limit %}min(vec4f({{ limit }}), {{ factor }} * sum){% else %}{{ factor }} * sum{% endif %};
}

fn place(cell: vec3u, n: u32) -> u32 { return cell.x + n * (cell.y + n * cell.z); }

@compute @workgroup_size(4, 4, 4)
fn main(@builtin(global_invocation_id) cell: vec3u, @builtin(local_invocation_id) at: vec3u,
        @builtin(workgroup_id) group: vec3u) {
    {% set parent = levels[1] %}
    let inside = all(cell < vec3u({{ parent.n }}u));
    for (var k = 0u; k < {{ per_cell }}u; k++) {
        var sum = vec4f(0.0);
        if inside {
            for (var child = 0u; child < 8u; child++) {
                let source = 2u * cell + vec3u(child & 1u, (child >> 1u) & 1u, child >> 2u);
                sum += cells[{{ per_cell }}u * ({{ levels[0].first }}u + place(source, {{ levels[0].n }}u)) + k];
            }
            cells[{{ per_cell }}u * ({{ parent.first }}u + place(cell, {{ parent.n }}u)) + k] = combined(sum);
        }
        {% if levels|length > 2 %}
        parents[{{ per_cell }}u * place(at, 4u) + k] = combined(sum);
        {% endif %}
    }
    {% for level in levels[2:] %}
    {% set tile, edge, own = ("parents", 4, 2) if loop.first else ("grandparents", 2, 1) %}
    workgroupBarrier();
    let cell_{{ level.n }} = group * {{ own }}u + at;
    if all(at < vec3u({{ own }}u)) && all(cell_{{ level.n }} < vec3u({{ level.n }}u)) {
        for (var k = 0u; k < {{ per_cell }}u; k++) {
            var sum = vec4f(0.0);
            for (var child = 0u; child < 8u; child++) {
                let source = 2u * at + vec3u(child & 1u, (child >> 1u) & 1u, child >> 2u);
                sum += {{ tile }}[{{ per_cell }}u * place(source, {{ edge }}u) + k];
            }
            cells[{{ per_cell }}u * ({{ level.first }}u + place(cell_{{ level.n }}, {{ level.n }}u)) + k] = combined(sum);
            {% if not loop.last %}
            grandparents[{{ per_cell }}u * place(at, 2u) + k] = combined(sum);
            {% endif %}
        }
    }
    {% endfor %}
}
