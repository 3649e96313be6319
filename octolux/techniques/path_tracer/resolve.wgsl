// Means of the sums over paths, and the standard error of a pixel's luminance.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) pixel: vec3u) {
    if any(pixel.xy >= textureDimensions(radiance_sum)) { return; }
    let radiance = textureLoad(radiance_sum, pixel.xy, 0);
    let direct = textureLoad(direct_sum, pixel.xy, 0);
    let mean = radiance / settings.count;
    let luminance = dot(mean.rgb, {{ luminance }});
    let variance = max(direct.w / settings.count - luminance * luminance, 0.0) / max(settings.count - 1.0, 1.0);
    textureStore(radiance_out, pixel.xy, mean);
    textureStore(indirect_out, pixel.xy, textureLoad(indirect_sum, pixel.xy, 0) / settings.count);
    textureStore(direct_out, pixel.xy, vec4f(direct.rgb / settings.count, sqrt(variance)));
}
