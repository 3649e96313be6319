// How many bits are set in each word, from parameters.first.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + {{ row }}u * id.y;
    if index < parameters.count { values[index] = countOneBits(bits[parameters.first + index]); }
}
