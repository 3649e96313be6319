// The directory that is read where something moves: that of what is static, but where any of a word's nodes are of what moves
// all have new numbers, behind those of what is static (from parameters.first on).
@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let word = id.x + {{ row }}u * id.y;
    if word >= parameters.count { return; }
    let place = vec2u(word & {{ directory_row - 1 }}u, word / {{ directory_row }}u);
    let number = parameters.first + values[word] + totals[word / {{ block }}u];
    let of_static = textureLoad(static_directory, place, 0);
    textureStore(directory, place, select(of_static, vec4u(merged[word], number, 0u, 0u), merged[word] != 0u));
}
