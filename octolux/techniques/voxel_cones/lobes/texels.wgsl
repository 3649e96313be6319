// A texel of the first two of a node's bricks (representation.py, bricks/bricks.wgsl): light and its moment, as shares of one
// scale, and what faces +x and +y. A moment of 0 is 128/255.
{{ use("techniques/voxel_cones/bricks/facing.wgsl") }}
{{ use("techniques/voxel_cones/lobes/moment.wgsl") }}

fn store_texel(texel: vec3u, way: u32, sent: vec3f, over: f32, from_voxel: Borrowed) {
    let moment = select(vec3f(0.0), unpack_moment(light[from_voxel.lit + 8u]), from_voxel.there);
    let signed = {{ 128 / 255 }} + {{ 127 / 255 }} * over * moment;
    let up = select(vec3f(0.0), unpack_shares(facing[from_voxel.faces]), from_voxel.there);
    textureStore(bricks, texel, vec4f(sent, signed.x));
    textureStore(bricks, texel + vec3u(3u, 0u, 0u), vec4f(signed.yz, up.xy));
}
