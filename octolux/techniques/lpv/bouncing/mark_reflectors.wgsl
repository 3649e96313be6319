// Asks for the cells of the last window that have something which reflects.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= {{ n**3 }}u { return; }
    let at = 3u * (id.x + {{ (windows - 1) * n**3 }}u);
    let any_face = dot(reflectors[at] , vec4f(1.0)) + reflectors[at + 1u].x + reflectors[at + 1u].y;
    marks[id.x] = select(0u, 1u, any_face > 0.0);
}
