// Nodes of the octree as cells read them (simulator/lpv/gathering.py): where their light is, and for each channel the
// flux per steradian of the dominant lobe, as a vector, and of the isotropic rest.
{{ use("shaders/sh.wgsl") }}
{{ use("techniques/lpv/octree/addresses.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let number = id.x + {{ row }}u * id.y;
    if number >= {{ cells }}u { return; }
    let moment = moments[number];
    var place = vec4f(0.0);
    if moment.w > 0.0 { place = vec4f(moment.xyz / moment.w, moment.w); }
    nodes[4u * number] = place;
    for (var channel = 0u; channel < 3u; channel++) {
        let lobe = sh_dominant_lobe(injected[3u * number + channel]);
        let directed = lobe.flux * lobe.fraction;
        nodes[4u * number + 1u + channel] = vec4f(
            directed * {{ 1 / pi }} * lobe.direction, (lobe.flux - directed) * {{ 1 / (4 * pi) }}
        );
    }
}
