// The geometry volume's next coarser level (simulator/lpv/geometry.py, `coarser_planes`): fronts and backs are each
// a quarter of the children's sum, as the cross section is four times as large, and lie where theirs do on average.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id >= vec3u({{ child_n // 2 }}u)) { return; }
    let number = {{ parent_first }}u + id.x + {{ child_n // 2 }}u * (id.y + {{ child_n // 2 }}u * id.z);
    var front = vec4f(0.0);
    var back = vec4f(0.0);
    {% for place in ("offset", "next", "last") %}
    var {{ place }} = vec4f(0.0);
    {% endfor %}
    for (var child = 0u; child < 8u; child++) {
        let corner = vec3u(child & 1u, (child >> 1u) & 1u, child >> 2u);
        let at = 2u * id + corner;
        let source = {{ child_first }}u + at.x + {{ child_n }}u * (at.y + {{ child_n }}u * at.z);
        let child_front = 0.25 * fronts[source];
        let child_back = 0.25 * backs[source];
        front += child_front;
        back += child_back;
        {% for place, axes in (("offset", "xyz"), ("next", "yzx"), ("last", "zxy")) %}
        {{ place }} += (child_front + child_back) * 0.5 * ({{ place }}s[source] + vec4f(vec3f(corner.{{ axes }}), 0.0));
        {% endfor %}
    }
    fronts[number] = min(vec4f(1.0), front);
    backs[number] = min(vec4f(1.0), back);
    {% for place in ("offset", "next", "last") %}
    {{ place }}s[number] = {{ place }} / max(front + back, vec4f(1e-20));
    {% endfor %}
}
