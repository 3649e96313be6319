// Numbers of nodes: the directory (octree.wgsl), and the code of each node.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let word = id.x + {{ row }}u * id.y;
    if word >= parameters.count { return; }
    var mask = nodes[word];
    var number = values[word] + totals[word / {{ block }}u];
    textureStore(directory, vec2u(word & {{ directory_row - 1 }}u, word / {{ directory_row }}u), vec4u(mask, number, 0u, 0u));
    while mask != 0u {
        codes[number] = 32u * word + firstTrailingBit(mask);
        number += 1u;
        mask &= mask - 1u;
    }
}
