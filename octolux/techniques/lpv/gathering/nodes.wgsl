// Nodes of the octree as cells read them (simulator/lpv/gathering.py): the place of their light and its weight, and for each
// channel the flux per steradian of the dominant lobe, as a vector, and of the isotropic rest, as half floats of the weight:
// at most some 2.3 of it, in light of one colour.
{{ use("shaders/sh.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let number = id.x + {{ row }}u * id.y;
    if number >= {{ cells }}u { return; }
    let moment = moments[number];
    let weight = max(moment.w, 0.0);
    let scale = select(0.0, 1.0 / weight, weight > 0.0);
    {% for channel in range(3) %}
    let lobe_{{ channel }} = sh_dominant_lobe(injected[3u * number + {{ channel }}u] * scale);
    let directed_{{ channel }} = lobe_{{ channel }}.flux * lobe_{{ channel }}.fraction;
    let along_{{ channel }} = directed_{{ channel }} * {{ 1 / pi }} * lobe_{{ channel }}.direction;
    let halves_{{ channel }} = vec2u(
        pack2x16float(along_{{ channel }}.xy),
        pack2x16float(vec2f(along_{{ channel }}.z, (lobe_{{ channel }}.flux - directed_{{ channel }}) * {{ 1 / (4 * pi) }})),
    );
    {% endfor %}
    store_nodes(number, Node(moment.xyz * scale, weight, vec4u(halves_0, halves_1), vec4u(halves_2, 0u, 0u)));
}
