// Windows that have moved by whole cells keep what their cells hold in its place in the world, but for what is forgotten;
// cells that come in are empty.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let window = id.z / {{ n }}u;
    let before = vec3i(vec3u(id.xy, id.z % {{ n }}u)) + shifts[window].cells;
    let cell = id.x + {{ n }}u * (id.y + {{ n }}u * id.z);
    let inside = all(before >= vec3i(0)) && all(before < vec3i({{ n }}));
    let source = select(0u, {{ n }}u * {{ n }}u * {{ n }}u * window + u32(before.x + {{ n }} * (before.y + {{ n }} * before.z)), inside);
    let kept = inside && ((forgotten[cell >> 5u] >> (cell & 31u)) & 1u) == 0u;
    {% for k in range(count) %}
    cells_out[{{ count }}u * cell + {{ k }}u] = select(vec4f(0.0), cells[{{ count }}u * source + {{ k }}u], kept);
    {% endfor %}
}
