// Which nodes are read that what moves, or what is static in the same words of the directory, has (merge_directory.wgsl): bits
// of both where any of what moves are `shown`, and how many.
@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let word = id.x + {{ row }}u * id.y;
    if word >= parameters.count { return; }
    let static_mask = textureLoad(static_directory, vec2u(word & {{ directory_row - 1 }}u, word / {{ directory_row }}u), 0).x;
    let bits = select(0u, shown[word] | static_mask, shown[word] != 0u);
    merged[word] = bits;
    values[word] = countOneBits(bits);
}
