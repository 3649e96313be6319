// Shares of the surfels that the camera sees.
{{ use("techniques/lpv/surfel.wgsl") }}
{{ use("techniques/lpv/surfel_of_pixel.wgsl") }}
{% if static_only %}
{{ use("shaders/pixel_traits.wgsl") }}

fn traits_at(number: u32) -> u32 { return pixel_traits(surfel_pixel(number)); }
{% endif %}
