// Reflectors (simulator/lpv/reflectors.py): of each surfel the shares of its cell's cross section that face the six
// directions, summed for each buffer, and its albedo times its area, {% if places %}and its place in the cell, {% endif %}summed over all buffers, all in fixed point.
//
// A thread walks down {{ run }} surfels of a map's column and scatters what it has added up when it meets a third cell, as
// inject.wgsl does and for its reasons. Each surfel is rounded by itself, so the sums have the same bits in any order.
{{ use("shaders/traits.wgsl") }}
{{ use("techniques/lpv/cell_in_grids.wgsl") }}

struct Surfel { position: vec3f, normal: vec3f, area: f32 } // no area: nothing is there
// Up to a whole wall along each axis, towards its upper and its lower end; red, green, blue and area.
struct Sums { upper: vec3u, lower: vec3u, tint: vec4u{% if places %}, place: vec3u{% endif %} }

fn sums_of(surfel: Surfel, albedo: vec3f, held: Held) -> Sums {
    let walls = surfel.area * per_cross_section(held.cell);
    let facing = {{ "surfel.normal * abs(surfel.normal)" if squares else "surfel.normal" }};
    let upper = {{ one }}.0 * min(vec3f(1.0), max(vec3f(0.0), facing) * walls);
    let lower = {{ one }}.0 * min(vec3f(1.0), max(vec3f(0.0), -facing) * walls);
    let weight = min({{ most_walls }}.0, walls) * {{ tint_one }}.0;
    {% if places %}
    let place = 0.5 * (held.unshifted + 0.5); // 0 to 1: at most a cell from its middle
    {% endif %}
    return Sums(vec3u(round(upper)), vec3u(round(lower)), vec4u(round(weight * vec4f(albedo, 1.0))){% if places %},
                vec3u(round(weight * place)){% endif %});
}

fn sum_of(a: Sums, b: Sums, taken: bool) -> Sums {
    return Sums(a.upper + select(vec3u(0u), b.upper, taken), a.lower + select(vec3u(0u), b.lower, taken),
                a.tint + select(vec4u(0u), b.tint, taken){% if places %},
                a.place + select(vec3u(0u), b.place, taken){% endif %});
}

// A walk that brings a whole wall closes the cell: more would only come nearer to 2^32.
fn add_share(at: u32, share: u32) {
    if share > 0u && atomicLoad(&sums[at]) < {{ one }}u { atomicAdd(&sums[at], min(share, {{ one }}u)); }
}

// A mean has no bound at which more does not count: sums have 64 bits, the lower word first.
fn add_tint(at: u32, value: u32) {
    if value > 0u {
        let before = atomicAdd(&tints[at], value);
        if before > 0xffffffffu - value { atomicAdd(&tints[at + 1u], 1u); }
    }
}

fn scatter(cell: u32, sum: Sums) {
    let at = 6u * (surfels.sums + cell);
    {% for axis in range(3) %}
    add_share(at + {{ 2 * axis }}u, sum.upper[{{ axis }}]);
    add_share(at + {{ 2 * axis + 1 }}u, sum.lower[{{ axis }}]);
    {% endfor %}
    {% for k in range(4) %}
    add_tint({{ 14 if places else 8 }}u * cell + {{ 2 * k }}u, sum.tint[{{ k }}]);
    {% endfor %}
    {% if places %}{% for k in range(3) %}
    add_tint(14u * cell + {{ 8 + 2 * k }}u, sum.place[{{ k }}]);
    {% endfor %}{% endif %}
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let start = id.x / surfels.width * ({{ run }}u * surfels.width) + id.x % surfels.width;
    if start >= surfels.count { return; }
    let steps = min({{ run }}u, (surfels.count - 1u - start) / surfels.width + 1u);
    var i = 0u;
    loop {
        var one = NOWHERE;
        var other = NOWHERE;
        var of_one = Sums();
        var of_other = Sums();
        loop {
            let number = start + i * surfels.width;
            let surfel = surfel_at(number);
            let held = held_by(id.y, surfel.position, {{ offset }} * surfel.normal);
            let cell = held.cell;
            let used = surfel.area > 0.0 && cell != NOWHERE{% if static_only %} && !unpack_traits(traits_at(number)).moving{% endif %};
            one = select(one, cell, used && one == NOWHERE);
            other = select(other, cell, used && cell != one && other == NOWHERE);
            if used && cell != one && cell != other { break; }
            let sums = sums_of(surfel, unpack_traits(traits_at(number)).albedo, held);
            of_one = sum_of(of_one, sums, used && cell == one);
            of_other = sum_of(of_other, sums, used && cell == other);
            i++;
            if i >= steps { break; }
        }
        if one != NOWHERE { scatter(one, of_one); }
        if other != NOWHERE { scatter(other, of_other); }
        if i >= steps { break; }
    }
}
