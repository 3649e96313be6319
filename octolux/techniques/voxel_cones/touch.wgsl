// Nodes whose light is to be made anew: those of which a child's was.
{{ use("techniques/voxel_cones/octree.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + {{ row }}u * id.y;
    if index >= parameters.count { return; }
    let node = parameters.first + index;
    let children = children_of(codes[node]);
    var any = 0u;
    for (var k = 0u; k < children.count; k++) { any |= touched[children.first + k]; }
    touched[node] = any;
}
