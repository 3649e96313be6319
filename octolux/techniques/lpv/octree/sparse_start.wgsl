// Before the first step: each leaf has the injected light of what it covers, scaled for storage.
{{ use("techniques/lpv/cells.wgsl") }}
{{ use("techniques/lpv/octree/sparse_nodes.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let slot = thread_of(id);
    if slot >= 8u * count[0] { return; }
    let node = node_of(slot);
    let scale = select(0.0, storage_scale(peak[0]), children_of(node.level, node.cell) == 0u); // else the slot is empty
    for (var channel = 0u; channel < 3u; channel++) {
        let c = injected[3u * number_of(node.level, node.cell) + channel] * scale;
        light[3u * slot + channel] = c;
        store_at(3u * slot + channel, to_emission(c));
    }
}
