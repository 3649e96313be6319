// Light in the air at given places: position in, fluence and step out.
{{ use("techniques/lpv/volume_light.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= {{ threads }}u { return; }
    let position = vec3f(given[3u * id.x], given[3u * id.x + 1u], given[3u * id.x + 2u]);
    let fluence = volume_fluence(position);
    for (var i = 0u; i < 3u; i++) { result[4u * id.x + i] = fluence[i]; }
    result[4u * id.x + 3u] = volume_step(position);
}
