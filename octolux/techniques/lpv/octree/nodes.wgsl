// Nodes of the octree as cells read them (simulator/lpv/gathering.py), in 48 bytes: the place of their light and its weight,
// and for each channel the flux per steradian of the dominant lobe, as a vector, and of the isotropic rest, as half floats
// of the weight: at most some 2.3 of it, in light of one colour.
{{ use("shaders/sh.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let number = id.x + {{ row }}u * id.y;
    if number >= {{ cells }}u { return; }
    let moment = moments[number];
    if moment.w <= 0.0 {
        nodes[3u * number] = vec4u(0u);
        return;
    }
    nodes[3u * number] = bitcast<vec4u>(vec4f(moment.xyz / moment.w, moment.w));
    {% for channel in range(3) %}
    let lobe_{{ channel }} = sh_dominant_lobe(injected[3u * number + {{ channel }}u] / moment.w);
    let directed_{{ channel }} = lobe_{{ channel }}.flux * lobe_{{ channel }}.fraction;
    let along_{{ channel }} = directed_{{ channel }} * {{ 1 / pi }} * lobe_{{ channel }}.direction;
    let halves_{{ channel }} = vec2u(
        pack2x16float(along_{{ channel }}.xy),
        pack2x16float(vec2f(along_{{ channel }}.z, (lobe_{{ channel }}.flux - directed_{{ channel }}) * {{ 1 / (4 * pi) }})),
    );
    {% endfor %}
    nodes[3u * number + 1u] = vec4u(halves_0, halves_1);
    nodes[3u * number + 2u] = vec4u(halves_2, 0u, 0u);
}
