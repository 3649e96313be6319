// Shares of the surfels that the camera sees.
{{ use("techniques/lpv/surfel.wgsl") }}
{{ use("techniques/lpv/surfel_of_pixel.wgsl") }}
