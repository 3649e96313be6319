// The geometry volume in four words a cell: for each axis the strip of its plane (simulator/lpv/strips.py, `Planes.strips` and
// `pack_planes`).

const STEPS = {{ strip_steps }}.0;

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let number = id.x + {{ row }}u * id.y;
    if number >= {{ cells }}u { return; }
    let share = max(fronts[number].xyz, backs[number].xyz);
    let aside_next = abs(nexts[number].xyz - 0.5);
    let aside_last = abs(lasts[number].xyz - 0.5);
    let along_last = aside_last > aside_next + {{ 0.5 / strip_steps }};
    let middle = select(nexts[number].xyz, lasts[number].xyz, along_last);
    let widest = 1.0 - 2.0 * select(aside_next, aside_last, along_last);
    let width = max(widest, max(share, vec3f({{ 1 / strip_steps }})));
    let from_low = clamp(middle - 0.5 * width, vec3f(0.0), 1.0 - width);
    let low = vec3u(floor(STEPS * from_low + 0.5));
    let high = vec3u(floor(STEPS * (from_low + width) + 0.5));
    let density = vec3u(round(STEPS * min(vec3f(1.0), STEPS * share / vec3f(max(high - low, vec3u(1u))))));
    let place = min(vec3u(STEPS * offsets[number].xyz), vec3u({{ strip_steps - 1 }}u));
    let axis = select(vec3u(0u), vec3u(1u), along_last);
    {% set names = ("density", "place", "low", "high", "axis") %}
    let words = {% for name in names %}({{ name }} << vec3u({{ strip_bits[loop.index0] }}u)){{ "" if loop.last else " | " }}{% endfor %};
    packed[number] = vec4u(select(vec3u(0u), words, share > vec3f(0.0)), 0u);
}
