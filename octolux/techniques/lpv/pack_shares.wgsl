// The geometry volume in the bytes of a word: a share errs by at most 1/510.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let number = id.x + {{ row }}u * id.y;
    if number < {{ cells }}u { packed[number] = pack4x8unorm(shares[number]); }
}
