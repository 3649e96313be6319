// Test kernel: a direction packed, and another one unpacked. The 32 bits travel as two floats of 16 bits each, since a
// float may not keep the bits of a NaN.
{{ use("shaders/octahedral.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= {{ threads }}u { return; }
    let i = 5u * id.x;
    let packed = pack_unit_vector(vec3f(given[i], given[i + 1u], given[i + 2u]));
    let v = unpack_unit_vector(u32(given[i + 3u]) | u32(given[i + 4u]) << 16u);
    result[i] = f32(packed & 65535u);
    result[i + 1u] = f32(packed >> 16u);
    for (var k = 0u; k < 3u; k++) { result[i + 2u + k] = v[k]; }
}
