// From the touched nodes of a level to the next: the voxel that each is made into is made anew, and its node touched; and all
// bricks that hold voxels of it are listed (VCT 5.5). Eight threads for a node: one for each of its ways, and one for each node
// at its lower sides, whose bricks hold some of its voxels.
{{ use("techniques/voxel_cones/octree/octree.wgsl") }}
{{ use(coarser_light) }}
{{ use("techniques/voxel_cones/bricks/touch.wgsl") }}

const BRICKS = {{ depth }}u; // their list

fn list_bricks(node: u32) {
    if (atomicOr(&touched[node], 2u) & 2u) != 0u { return; }
    let count = countOneBits(ways[node] & 63u);
    let first = longer(BRICKS, count);
    need_threads(BRICKS, first + count);
    for (var k = 0u; k < count; k++) { update_list[first + k] = (ways[node] >> 6u) + k; }
}

// parameters: count: the level; first, second: where its segment of node_list and that of the next begin.
@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let thread = id.x + {{ row }}u * id.y;
    let level = parameters.count;
    if thread >= 8u * atomicLoad(&lists[4u * level + 3u]) { return; }
    let node = node_list[parameters.first + (thread >> 3u)];
    let way = thread & 7u;
    let code = codes[node];
    let offset = vec3u(way & 1u, (way >> 1u) & 1u, way >> 2u);
    let cell = cell_of(code);
    if all(cell >= offset) {
        let beside = node_of(code_of(log2_edge_of(code), cell - offset));
        if beside != NO_NODE { list_bricks(beside); }
    }
    if code == 1u { return; }
    let parent = node_of(code >> 3u);
    if way == 7u { touch(parent, level + 1u, parameters.second); }
    if way >= 6u { return; }
    let brick = brick_of_way(ways[parent], way);
    if brick != NO_NODE { coarser_light(parent, brick, way, code & 7u, node); }
}
