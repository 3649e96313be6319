// Owen-scrambled Sobol points, two dimensions at a time (Burley 2020, "Practical Hash-based Owen Scrambling"): each pair is the
// (0,2)-sequence, scrambled and shuffled by hashes of pixel and pair, so that every prefix of 2^k points is stratified and
// different pairs are independent. Deterministic by seed.

struct Sampler { index: u32, seed: u32, pair: u32 }

// PCG (Jarzynski and Olano 2020).
fn hash_u32(value: u32) -> u32 {
    let state = value * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

fn combine_hashes(a: u32, b: u32) -> u32 { return hash_u32(a ^ (b + 0x9e3779b9u + (a << 6u) + (a >> 2u))); }

// Laine and Karras 2011, with Vegdahl's constants (2021): scrambles from the lowest bit up.
fn laine_karras(value: u32, seed: u32) -> u32 {
    var x = value ^ (value * 0x3d20adeau);
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

fn nested_scramble(value: u32, seed: u32) -> u32 { return reverseBits(laine_karras(reverseBits(value), seed)); }

// The second dimension of Sobol's sequence, bits reversed: bit i is the sum modulo 2 of all bits k of the index for which
// binomial(k, i) is odd, which is where i is a part of k in binary (Lucas 1878); one step for each bit of their numbers.
fn sobol_second_reversed(index: u32) -> u32 {
    var bits = index;
    bits ^= (bits >> 1u) & 0x55555555u;
    bits ^= (bits >> 2u) & 0x33333333u;
    bits ^= (bits >> 4u) & 0x0f0f0f0fu;
    bits ^= (bits >> 8u) & 0x00ff00ffu;
    bits ^= bits >> 16u;
    return bits;
}

fn unit_float(bits: u32) -> f32 { return f32(bits >> 8u) / 16777216.0; }

fn start_sampler(pixel: vec2u, index: u32, seed: u32) -> Sampler {
    // One number for each pixel, led through a bijection: no two pixels of a picture take the same points.
    return Sampler(index, combine_hashes(hash_u32(pixel.y << 16u | pixel.x), seed), 0u);
}

// The next two numbers in [0, 1).
fn next_2d(s: ptr<function, Sampler>) -> vec2f {
    let seed = combine_hashes((*s).seed, (*s).pair);
    (*s).pair += 1u;
    let index = nested_scramble((*s).index, seed);
    // Both dimensions are scrambled in bit-reversed form, which they have already.
    let x = reverseBits(laine_karras(index, hash_u32(seed ^ 0x2c1b3c6du)));
    let y = reverseBits(laine_karras(sobol_second_reversed(index), hash_u32(seed ^ 0x297a2d39u)));
    return vec2f(unit_float(x), unit_float(y));
}
