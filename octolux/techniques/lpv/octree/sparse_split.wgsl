// Cells of level {{ level }} that are split (simulator/lpv/sparse.py, `build_tree`): each gets a brick. Bricks are numbered in
// any order: no result depends on it.
{{ use("techniques/lpv/octree/sparse_nodes.wgsl") }}

fn marked(cell: vec3i) -> u32 {
    let inside = all(cell >= vec3i(0)) && all(cell < vec3i({{ edge }}));
    let at = vec3u(clamp(cell, vec3i(0), vec3i({{ edge - 1 }})));
    return select(0u, atomicLoad(&marks[split_number({{ level }}u, at)]), inside);
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) cell: vec3u) {
    if any(cell >= vec3u({{ edge }}u)) { return; }
    // Children that are lit or split, up to {{ margin }} of their cells away: of those around, these bits.
    var near = {{ "1u" if edge == 1 else "0u" }};
    {% for part in around if edge > 1 %}
    near |= marked(vec3i(cell) + vec3i({{ part.offset|join(", ") }})) & {{ part.bits }}u;
    {% endfor %}
    let number = split_number({{ level }}u, cell);
    if near == 0u {
        brick_numbers[number] = 0u;
        return;
    }
    let brick = atomicAdd(&count[0], 1u);
    brick_numbers[number] = brick + 1u;
    bricks[brick] = pack_brick({{ level - 1 }}u, cell);
    {% if edge > 1 %}
    atomicOr(&marks[split_number({{ level + 1 }}u, cell >> vec3u(1u))], 1u << corner_of(cell));
    {% endif %}
}
