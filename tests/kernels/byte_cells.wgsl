// Test kernel: an emission packed for the storage index of the thread, as two numbers of 16 bits (a float may not keep the
// bits of a NaN), and unpacked again.
{{ use("techniques/lpv/cells.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= {{ threads }}u { return; }
    let i = 4u * id.x;
    let word = pack_byte_cell(vec4f(given[i], given[i + 1u], given[i + 2u], given[i + 3u]), id.x);
    let e = unpack_byte_cell(word);
    let out = 6u * id.x;
    result[out] = f32(word & 65535u);
    result[out + 1u] = f32(word >> 16u);
    for (var k = 0u; k < 4u; k++) { result[out + 2u + k] = e[k]; }
}
