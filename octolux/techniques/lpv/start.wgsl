// Before the first step: injected light, scaled for storage, is the first term of the sum and what the cells send.
{{ use("techniques/lpv/cells.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x;
    if index >= arrayLength(&light) { return; }
    let c = injected[index] * storage_scale(peak[0]);
    light[index] = c;
    store(index, to_emission(c));
}
