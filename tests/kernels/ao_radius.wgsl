// Radii that change in the room, from `given`: what a technique with nested volumes has.
fn ao_radii(position: vec3f, normal: vec3f) -> Radii {
    return Radii(given.near, {{ times }} * given.near, clamp(0.5 - {{ per_metre }} * (position.x - given.border), 0.0, 1.0));
}
