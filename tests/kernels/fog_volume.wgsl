// A light volume that is the same everywhere.
fn volume_fluence(position: vec3f) -> vec3f { return vec3f({{ even_fluence }}); }
fn volume_step(position: vec3f) -> f32 { return {{ even_cell }}; }
