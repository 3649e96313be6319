// A texel of a brick (bricks/bricks.wgsl): light that is sent one way, and the share of the section that faces there.
{{ use("techniques/voxel_cones/bricks/facing.wgsl") }}

fn store_texel(texel: vec3u, way: u32, sent: vec3f, over: f32, from_voxel: Borrowed) {
    let share = select(0.0, share_of(facing[from_voxel.faces], way >> 1u), from_voxel.there);
    textureStore(bricks, texel, vec4f(sent, share));
}
