// What the surfaces of all cells of the last window receive, as a share of what has been sent, in each colour: in fixed point,
// so that it has the same bits in any order. The root of the octree holds all that has been sent.
{{ use("techniques/lpv/bouncing/cube.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id >= vec3u({{ n }}u)) { return; }
    let at = 3u * ({{ (windows - 1) * n**3 }}u + id.x + {{ n }}u * (id.y + {{ n }}u * id.z));
    let xy = reflectors[at];
    let z = reflectors[at + 1u];
    if all(xy == vec4f(0.0)) && all(z.xy == vec2f(0.0)) { return; }
    let c = gathered(id, vec3f(1.0));
    let flux = xy.x * c.x[0] + xy.y * c.x[1] + xy.z * c.y[0] + xy.w * c.y[1] + z.x * c.z[0] + z.y * c.z[1];
    let sent = vec3f({% for channel in range(3) %}light[{{ 3 * last_cell + channel }}u].x{% if not loop.last %}, {% endif %}{% endfor %}) * {{ 1 / sh_y0 }};
    let share = vec3u(round(flux / max(sent, vec3f(1e-30)) * {{ one }}.0));
    {% for channel in range(3) %}
    atomicAdd(&received[{{ channel }}], share[{{ channel }}]);
    {% endfor %}
}
