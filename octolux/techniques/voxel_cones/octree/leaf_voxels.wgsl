// Of each node of level 0 which of its eight voxels are occupied, and the number of the first: voxels are numbered by codes.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + {{ row }}u * id.y;
    if index >= parameters.count { return; }
    let code = codes[parameters.first + index];
    let word = code >> 2u; // four nodes have a word
    let voxels = occupied[word];
    let shift = 8u * (code & 3u);
    let place = word - parameters.second;
    let number = values[place] + totals[place / {{ block }}u] + countOneBits(voxels & ((1u << shift) - 1u));
    store_leaves(index, (number << 8u) | ((voxels >> shift) & 255u));
}
