// Clusters lie in textures, two words each: a box (f32), its node and how many triangles it holds.

fn cluster_word(word: u32) -> vec2u { return vec2u(word & {{ 2 ** row_bits - 1 }}u, word >> {{ row_bits }}u); }
