// A radius that changes in the room, from `given`: what a technique with nested volumes has.
fn ao_radius(position: vec3f) -> f32 { return given.near * select({{ times }}, 1.0, position.x < given.border); }
