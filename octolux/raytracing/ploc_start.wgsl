// Every triangle, in sorted order, is a cluster and a leaf of the binary tree. Leaf nodes name their triangle twice.
{{ use("raytracing/ploc_clusters.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    if i >= parameters.count { return; }
    let triangle = keys[i].z;
    let low = boxes[2u * triangle];
    let high = boxes[2u * triangle + 1u];
    textureStore(clusters, cluster_word(2u * i), vec4u(low.xyz, i));
    textureStore(clusters, cluster_word(2u * i + 1u), vec4u(high.xyz, 1u));
    tree[2u * i] = low;
    tree[2u * i + 1u] = high;
}
