// Before the first step: injected light, scaled for storage, is the first term of the sum and what the cells send.
{{ use("techniques/lpv/cells.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id >= vec3u({{ n }}u)) { return; }
    let scale = storage_scale(peak[0]);
    for (var channel = 0u; channel < 3u; channel++) {
        let index = light_index(vec3i(id), channel);
        let c = injected[index] * scale;
        light[index] = c;
        store(vec3i(id), channel, to_emission(c));
    }
}
