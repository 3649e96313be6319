// One radius for the whole picture, metres. Another file with this function in its place may ask where the surface is.
fn ao_radii(position: vec3f, normal: vec3f) -> Radii { return Radii(ao_extent.radius, ao_extent.radius, 1.0); }
