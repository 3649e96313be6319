// Traits of what the camera sees in a pixel (frame/traits.py, `pixel_bindings`); 0 where it sees nothing.
{{ use("shaders/gbuffer.wgsl") }}
{{ use("shaders/traits.wgsl") }}

fn pixel_traits(pixel: vec2u) -> u32 {
    let id = textureLoad(id_map, pixel, 0).x;
    if id == 0u { return 0u; }
    let surface = unpack_surface(textureLoad(surface_map, pixel, 0));
    let instance = load_instances(load_items((id - 1u) / {{ cluster_triangles }}u).instance);
    return pack_traits(surface.base_color * (1.0 - surface.metallic), instance);
}
