// A cell's words of the geometry volume (simulator/lpv/strips.py, `pack_planes`): for each axis the density of what is blocked of
// its cross section, where in the cell, and the low and the high end of the strip there, along the next axis or the last.
fn in_steps(words: vec4u, first: u32) -> vec3f {
    return vec3f((words.xyz >> vec3u(first)) & vec3u({{ 2 * strip_steps - 1 }}u)) * {{ 1 / strip_steps }};
}
fn densities_of(words: vec4u) -> vec3f { return in_steps(words, {{ strip_bits[0] }}u); }
fn planes_of(words: vec4u) -> vec3f {
    return (vec3f((words.xyz >> vec3u({{ strip_bits[1] }}u)) & vec3u({{ strip_steps - 1 }}u)) + 0.5) * {{ 1 / strip_steps }};
}
fn lows_of(words: vec4u) -> vec3f { return in_steps(words, {{ strip_bits[2] }}u); }
fn highs_of(words: vec4u) -> vec3f { return in_steps(words, {{ strip_bits[3] }}u); }
fn are_along_last(words: vec4u) -> vec3<bool> { return words.xyz >= vec3u({{ 2 ** strip_bits[4] }}u); }
fn shares_of(words: vec4u) -> vec3f { return densities_of(words) * (highs_of(words) - lows_of(words)); }

// Which planes a way crosses that is sampled in steps: of a sample `within` a cell, those between the last sample, `back` before it,
// or where the cell begins, and this one, or the cell's end if the next, `ahead` of it, lies beyond. All are counted along the way.
fn are_crossed(plane: vec3f, within: vec3f, back: vec3f, ahead: vec3f) -> vec3<bool> {
    let from_here = select(vec3f(0.0), within - back, within > back);
    let to_here = select(within, vec3f(1.0), within + ahead >= vec3f(1.0));
    return (plane > from_here) & (plane <= to_here);
}
