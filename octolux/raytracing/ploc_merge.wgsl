// PLOC, step 3: pairs become nodes of the binary tree, numbered in the order of their clusters; what stays closes up.
{{ use("raytracing/ploc_clusters.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    if i >= parameters.count { return; }
    let other = nearest[i];
    let mutual = other != i && nearest[other] == i;
    if mutual && other < i { return; }
    let place = values[i] + totals[i / {{ block }}u];
    var low = textureLoad(clusters, cluster_word(2u * i));
    var high = textureLoad(clusters, cluster_word(2u * i + 1u));
    if mutual {
        let second_low = textureLoad(clusters, cluster_word(2u * other));
        let second_high = textureLoad(clusters, cluster_word(2u * other + 1u));
        let number = parameters.first + place.y;
        let joined_low = bitcast<vec3u>(min(bitcast<vec3f>(low.xyz), bitcast<vec3f>(second_low.xyz)));
        let joined_high = bitcast<vec3u>(max(bitcast<vec3f>(high.xyz), bitcast<vec3f>(second_high.xyz)));
        let count = high.w + second_high.w;
        tree[2u * number] = vec4u(joined_low, low.w);
        tree[2u * number + 1u] = vec4u(joined_high, second_low.w);
        sizes[number - parameters.second] = count;
        low = vec4u(joined_low, number);
        high = vec4u(joined_high, count);
    }
    textureStore(merged, cluster_word(2u * place.x), low);
    textureStore(merged, cluster_word(2u * place.x + 1u), high);
}
