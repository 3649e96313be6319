// Reflectors that the camera sees.
{{ use("techniques/lpv/reflectors.wgsl") }}
{{ use("techniques/lpv/surfel_of_pixel.wgsl") }}
{{ use("shaders/pixel_traits.wgsl") }}

fn traits_at(number: u32) -> u32 { return pixel_traits(surfel_pixel(number)); }
