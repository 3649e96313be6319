// Sixteen samples of a cube, one for each pixel of a 4 x 4 tile (reference: simulator/gtao.py, `tile_noise`): turn of the
// slices, place of the steps, and place of the radius in its falloff, each stratified into sixteenths. Ordered as Bayer's
// dither matrix, so that the tile's 2 x 2 quarters are stratified as well. No frame number: a still picture stands still.
fn tile_noise(pixel: vec2u) -> vec3f {
    let mixed = pixel.x ^ pixel.y;
    let k = (mixed & 1u) << 3u | (pixel.y & 1u) << 2u | (mixed & 2u) | (pixel.y & 2u) >> 1u;
    return (vec3f(vec3u(k, reverseBits(k) >> 28u, (5u * k) & 15u)) + 0.5) / 16.0;
}
