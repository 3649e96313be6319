// Which children of each cell of level 1 are lit: eight bits. A share of the peak counts as none (OLPV 4.2).
{{ use("techniques/lpv/storage_scale.wgsl") }}
{{ use("techniques/lpv/octree/sparse_nodes.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) cell: vec3u) {
    if any(cell >= vec3u(edge_of(1u))) { return; }
    let scale = storage_scale(peak[0]);
    var mask = 0u;
    for (var corner = 0u; corner < 8u; corner++) {
        let at = 3u * number_of(0u, 2u * cell + (vec3u(corner, corner >> 1u, corner >> 2u) & vec3u(1u)));
        let largest = max(injected[at].x, max(injected[at + 1u].x, injected[at + 2u].x));
        mask |= select(0u, 1u << corner, largest * scale > {{ threshold }});
    }
    marks[split_number(1u, cell)] = mask;
}
