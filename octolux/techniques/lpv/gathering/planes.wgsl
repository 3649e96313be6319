// A cell's word of the geometry volume (simulator/lpv/geometry.py, `pack_planes`): along each axis the share of its cross section
// that is blocked, and where in the cell, from 0 to 1.
fn axes_of(word: u32) -> vec3u { return vec3u(word, word >> 10u, word >> 20u); }
fn shares_of(word: u32) -> vec3f { return vec3f(axes_of(word) & vec3u(31u)) * {{ 1 / 31 }}; }
fn planes_of(word: u32) -> vec3f { return (vec3f((axes_of(word) >> vec3u(5u)) & vec3u(31u)) + 0.5) * {{ 1 / 32 }}; }

// What the geometry volume lets through, along each axis, of a way that is sampled in steps: of a sample at `at`, in cells of
// a level, the planes of its cell `word` between the last sample, `back` before it, or where the cell begins, and this one, or
// the cell's end if the next, `ahead` of it, lies beyond. Counted along the way, which goes `upwards` or not.
fn through_planes(word: u32, at: vec3f, upwards: vec3<bool>, back: vec3f, ahead: vec3f) -> vec3f {
    let share = shares_of(word);
    let plane = planes_of(word);
    let within = select(1.0 - fract(at), fract(at), upwards);
    let ahead_by = select(1.0 - plane, plane, upwards);
    let from_here = select(vec3f(0.0), within - back, within > back);
    let to_here = select(within, vec3f(1.0), within + ahead >= vec3f(1.0));
    return vec3f(1.0) - select(vec3f(0.0), share, (ahead_by > from_here) & (ahead_by <= to_here));
}
