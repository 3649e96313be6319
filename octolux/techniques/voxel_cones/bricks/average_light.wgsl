// Light of the voxels of a node from that of its children: a thread for each of the eight voxels of a brick's node.
{{ use("techniques/voxel_cones/octree/octree.wgsl") }}
{{ use(coarser_light) }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = 8u * parameters.first + id.x + {{ row }}u * id.y;
    if index >= 8u * (parameters.first + parameters.count) { return; }
    let owner = owners[index >> 3u];
    let child = node_of(8u * codes[owner >> 3u] + (index & 7u));
    if child != NO_NODE { coarser_light(owner >> 3u, index >> 3u, owner & 7u, index & 7u, child); }
}
