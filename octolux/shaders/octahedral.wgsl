// Unit vectors as two numbers in [-1, 1] (Cigolle et al. 2014, listing 1), and packed into 32 bits.

fn octahedral_fold(p: vec2f) -> vec2f {
    return (1.0 - abs(p.yx)) * select(vec2f(-1.0), vec2f(1.0), p >= vec2f(0.0));
}

fn octahedral_encode(v: vec3f) -> vec2f {
    let p = v.xy / (abs(v.x) + abs(v.y) + abs(v.z));
    return select(p, octahedral_fold(p), v.z < 0.0);
}

fn octahedral_decode(p: vec2f) -> vec3f {
    let z = 1.0 - abs(p.x) - abs(p.y);
    return normalize(vec3f(select(p, octahedral_fold(p), z < 0.0), z));
}

fn pack_unit_vector(v: vec3f) -> u32 { return pack2x16snorm(octahedral_encode(v)); }
fn unpack_unit_vector(packed: u32) -> vec3f { return octahedral_decode(unpack2x16snorm(packed)); }
