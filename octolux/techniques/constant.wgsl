// The same irradiance for every pixel.
@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) pixel: vec3u) {
    if any(pixel.xy >= textureDimensions(irradiance_out)) { return; }
    textureStore(irradiance_out, pixel.xy, vec4f(constant.irradiance, 1.0));
}
