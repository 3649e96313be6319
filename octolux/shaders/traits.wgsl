// Traits of a surface in one word (frame/traits.py): albedo as square roots of 8 bits, then the logarithm of its object's
// size in seven, and whether it moves in the highest.

struct Traits { albedo: vec3f, size: f32, moving: bool }

fn pack_traits(albedo: vec3f, instance: Instance) -> u32 {
    let smallest = {{ smallest_size }};
    let octaves = log2(max(instance.size, exp2(smallest))) - smallest;
    let code = u32(min(round({{ steps_per_octave }} * octaves), 127.0));
    return pack4x8unorm(vec4f(sqrt(max(albedo, vec3f(0.0))), 0.0)) | code << 24u | instance.moving << 31u;
}

fn unpack_traits(packed: u32) -> Traits {
    let root = unpack4x8unorm(packed).rgb;
    let octaves = f32((packed >> 24u) & 127u) * {{ 1 / steps_per_octave }};
    return Traits(root * root, exp2(octaves + {{ smallest_size }}), packed >> 31u == 1u);
}
