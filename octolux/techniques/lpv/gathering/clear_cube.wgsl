// Forgets what was gathered before: no light, and no weight when cells are filtered.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) texel: vec3u) {
    if all(texel < textureDimensions(cube_out)) { textureStore(cube_out, texel, vec4f(0.0)); }
}
