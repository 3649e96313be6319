// After a bounce: what the surfaces of the last window's cells reflect of it becomes the light of the next, and its irradiance
// is added to that of those before. All of it is dimmed if more has been received than was sent.
{{ use("techniques/lpv/bouncing/reflected.wgsl") }}
{{ use("techniques/lpv/bouncing/moment.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id >= vec3u({{ n }}u)) { return; }
    let number = id.x + {{ n }}u * (id.y + {{ n }}u * id.z);
    let kept = min(vec3f(1.0), {{ one }}.0 / max(vec3f(vec3u(received[0], received[1], received[2])), vec3f(1.0)));
    {% for face in range(6) %}
    let at_{{ face }} = id + vec3u(0u, 0u, {{ face * n }}u);
    let face_{{ face }} = vec4f(kept, 1.0) * textureLoad(cube, at_{{ face }}, 0);
    textureStore(sum_out, at_{{ face }}, vec4f(face_{{ face }}.rgb{% if not first %} + textureLoad(sum_so_far, at_{{ face }}, 0).rgb{% endif %}, face_{{ face }}.a));
    {% endfor %}
    let reflector = number + {{ (windows - 1) * n**3 }}u;
    let sent = reflected(reflector, gathered(id, kept));
    light[3u * number] = sent.red;
    light[3u * number + 1u] = sent.green;
    light[3u * number + 2u] = sent.blue;
    moments[number] = moment_of(sent, reflector, vec3i(id), {{ 2 ** (windows - 1) }}.0);
}
