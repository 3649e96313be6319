// A cell's words of the geometry volume (simulator/lpv/strips.py, `pack_planes`): for each axis the density of what is blocked of
// its cross section, where in the cell, and the low and the high end of the strip there, along the next axis or the last.
fn in_steps(words: vec4u, first: u32) -> vec3f { return vec3f((words.xyz >> vec3u(first)) & vec3u(63u)) * {{ 1 / 32 }}; }
fn densities_of(words: vec4u) -> vec3f { return in_steps(words, 0u); }
fn planes_of(words: vec4u) -> vec3f { return (vec3f((words.xyz >> vec3u(6u)) & vec3u(31u)) + 0.5) * {{ 1 / 32 }}; }
fn lows_of(words: vec4u) -> vec3f { return in_steps(words, 11u); }
fn highs_of(words: vec4u) -> vec3f { return in_steps(words, 17u); }
fn are_along_last(words: vec4u) -> vec3<bool> { return words.xyz >= vec3u({{ 2**23 }}u); }
fn shares_of(words: vec4u) -> vec3f { return densities_of(words) * (highs_of(words) - lows_of(words)); }

// Which planes a way crosses that is sampled in steps: of a sample `within` a cell, those between the last sample, `back` before it,
// or where the cell begins, and this one, or the cell's end if the next, `ahead` of it, lies beyond. All are counted along the way.
fn are_crossed(plane: vec3f, within: vec3f, back: vec3f, ahead: vec3f) -> vec3<bool> {
    let from_here = select(vec3f(0.0), within - back, within > back);
    let to_here = select(within, vec3f(1.0), within + ahead >= vec3f(1.0));
    return (plane > from_here) & (plane <= to_here);
}
