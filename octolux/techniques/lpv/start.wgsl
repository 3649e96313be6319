// Before the first step: injected light, scaled for storage, is the first term of the sum and what the cells send.
{{ use("techniques/lpv/cells.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&light) / 3u { return; }
    let scale = storage_scale(peak[0]);
    for (var index = 3u * id.x; index < 3u * id.x + 3u; index++) {
        let c = injected[index] * scale;
        light[index] = c;
        store(index, to_emission(c));
    }
}
