// PLOC, step 1: for each cluster the one among its {{ radius }} neighbours on either side whose common box has the least
// area. Equal areas are decided by the exclusive or of both numbers: both partners see the same, no two neighbours of
// one cluster have the same, and equal boxes pair off at once.
{{ use("raytracing/ploc_clusters.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    if i >= parameters.count { return; }
    let low = bitcast<vec3f>(textureLoad(clusters, cluster_word(2u * i)).xyz);
    let high = bitcast<vec3f>(textureLoad(clusters, cluster_word(2u * i + 1u)).xyz);
    var best = i;
    var best_area = 0.0;
    let end = min(i + {{ radius }}u, parameters.count - 1u);
    for (var j = max(i, {{ radius }}u) - {{ radius }}u; j <= end; j++) {
        let other_low = bitcast<vec3f>(textureLoad(clusters, cluster_word(2u * j)).xyz);
        let other_high = bitcast<vec3f>(textureLoad(clusters, cluster_word(2u * j + 1u)).xyz);
        let e = max(high, other_high) - min(low, other_low);
        let area = e.x * e.y + e.y * e.z + e.z * e.x;
        let nearer = area < best_area || (area == best_area && (i ^ j) < (i ^ best));
        if j != i && (best == i || nearer) {
            best = j;
            best_area = area;
        }
    }
    nearest[i] = best;
}
