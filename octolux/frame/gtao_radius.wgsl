// One radius for the whole picture, metres. Another file with this function in its place may ask where the surface is.
fn ao_radius(position: vec3f) -> f32 { return ao_extent.radius; }
