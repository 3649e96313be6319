// Downsampling from a window into the next: what its cells hold is added to their parents, which hold what lies outside the
// window's reach alone. Windows lie on whole parents (simulator/lpv/cascades.py).

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id >= vec3u({{ n // 2 }}u)) { return; }
    let corner = vec3u(windows[{{ level }}].origin / 2 - windows[{{ level + 1 }}].origin);
    let parent = corner + id;
    let own = {{ (level + 1) * n**3 }}u + parent.x + {{ n }}u * (parent.y + {{ n }}u * parent.z);
    for (var k = 0u; k < {{ per_cell }}u; k++) {
        var sum = vec4f(0.0);
        for (var child = 0u; child < 8u; child++) {
            let at = 2u * id + vec3u(child & 1u, (child >> 1u) & 1u, child >> 2u);
            sum += cells[{{ per_cell }}u * ({{ level * n**3 }}u + at.x + {{ n }}u * (at.y + {{ n }}u * at.z)) + k];
        }
        let all = cells[{{ per_cell }}u * own + k] + {{ factor }} * sum;
        cells[{{ per_cell }}u * own + k] = {% if limit %}min(vec4f({{ limit }}), all){% else %}all{% endif %};
    }
}
