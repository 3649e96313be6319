// After a bounce: what the surfaces of the last window's cells reflect of it becomes the light of the next, and its irradiance
// is added to that of those before.
{{ use("techniques/lpv/bouncing/reflected.wgsl") }}
{{ use("techniques/lpv/storage_scale.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id >= vec3u({{ n }}u)) { return; }
    let number = id.x + {{ n }}u * (id.y + {{ n }}u * id.z);
    {% for face in range(6) %}
    let at_{{ face }} = id + vec3u(0u, 0u, {{ face * n }}u);
    let face_{{ face }} = textureLoad(cube, at_{{ face }}, 0);
    textureStore(sum_out, at_{{ face }}, vec4f(face_{{ face }}.rgb{% if not first %} + textureLoad(sum_so_far, at_{{ face }}, 0).rgb{% endif %}, face_{{ face }}.a));
    {% endfor %}
    let factor = 1.0 / storage_scale(peak[0]);
    let received = Cube(
        mat2x3f(factor * face_0.rgb, factor * face_1.rgb), mat2x3f(factor * face_2.rgb, factor * face_3.rgb),
        mat2x3f(factor * face_4.rgb, factor * face_5.rgb),
    );
    let sent = reflected(number + {{ (windows - 1) * n**3 }}u, received);
    light[3u * number] = sent.red;
    light[3u * number + 1u] = sent.green;
    light[3u * number + 2u] = sent.blue;
}
