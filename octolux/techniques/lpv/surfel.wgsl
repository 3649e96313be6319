// Surfels' shares of the cross sections of the cells that they lie in (simulator/lpv/geometry.py), in fixed point.
//
// A thread walks down {{ run }} surfels of a map's column and adds up their shares while they lie in one cell. {% if planes %}Fifteen{% else %}Three{% endif %} numbers
// are few enough to be scattered in the loop, unlike inject.wgsl's twelve: no thread waits for another that has met a new
// cell. Each surfel is rounded by itself, so the sums have the same bits however the walks are cut.

struct Surfel { position: vec3f, normal: vec3f, area: f32 } // no area: nothing is there
{{ use("techniques/lpv/cell_in_grids.wgsl") }}
{% if planes %}

// The shares of what faces along each axis, of what faces against it, and how far along it both lie in the cell; and how far along
// the next axis and the last. How often each sum has gone beyond 32 bits is counted in a word more for every three, 10 bits an
// axis: these too are the same in any order.
fn scatter(cell: u32, fronts: vec3u, backs: vec3u, moments: vec3u, nexts: vec3u, lasts: vec3u) {
    {% for sums, names in (("sums", ("fronts", "backs", "moments")), ("sums_beside", ("nexts", "lasts"))) %}
    let at_{{ sums }} = {{ 4 * names|length }}u * (surfels.sums + cell);
    {% for name in names %}
    {% set i = loop.index0 %}
    var {{ name }}_beyond = 0u;
    {% for k in range(3) %}
    if {{ name }}[{{ k }}] > 0u && atomicAdd(&{{ sums }}[at_{{ sums }} + {{ 3 * i + k }}u], {{ name }}[{{ k }}]) > 0xffffffffu - {{ name }}[{{ k }}] {
        {{ name }}_beyond += {{ 1024 ** k }}u;
    }
    {% endfor %}
    if {{ name }}_beyond > 0u { atomicAdd(&{{ sums }}[at_{{ sums }} + {{ 3 * names|length + i }}u], {{ name }}_beyond); }
    {% endfor %}
    {% endfor %}
}
{% else %}

// A walk that brings a whole wall closes the cell: more would only come nearer to 2^32.
fn scatter(cell: u32, sum: vec3u) {
    let at = 3u * (surfels.sums + cell);
    let shares = min(sum, vec3u(u32(surfels.one)));
    {% for k in range(3) %}
    if shares[{{ k }}] > 0u && atomicLoad(&sums[at + {{ k }}u]) < u32(surfels.one) {
        atomicAdd(&sums[at + {{ k }}u], shares[{{ k }}]);
    }
    {% endfor %}
}
{% endif %}

{% set all_sums = "fronts, backs, moments, nexts, lasts" if planes else "sum" %}
@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let start = id.x / surfels.width * ({{ run }}u * surfels.width) + id.x % surfels.width;
    if start >= surfels.count { return; }
    let steps = min({{ run }}u, (surfels.count - 1u - start) / surfels.width + 1u);
    var i = 0u;
    var cell = NOWHERE;
    {% for name in all_sums.split(", ") %}
    var {{ name }} = vec3u(0u);
    {% endfor %}
    loop {
        let surfel = surfel_at(start + i * surfels.width);
        let held = held_by(id.y, surfel.position, {{ -behind }} * surfel.normal);
        let used = surfel.area > 0.0 && held.cell != NOWHERE{% if static_only %} && !unpack_traits(traits_at(start + i * surfels.width)).moving{% endif %};
        let next = select(cell, held.cell, used);
        let share = surfels.one * min(vec3f(1.0), abs(surfel.normal) * (surfel.area * per_cross_section(held.cell)));
        if next != cell && cell != NOWHERE { scatter(cell, {{ all_sums }}); }
        let rounded = select(vec3u(0u), vec3u(round(share)), used);
        {% if planes %}
        let front = surfel.normal > vec3f(0.0);
        fronts = select(fronts, vec3u(0u), next != cell) + select(vec3u(0u), rounded, front);
        backs = select(backs, vec3u(0u), next != cell) + select(rounded, vec3u(0u), front);
        {% for name, axes in (("moments", "xyz"), ("nexts", "yzx"), ("lasts", "zxy")) %}
        {{ name }} = select({{ name }}, vec3u(0u), next != cell) + select(vec3u(0u), vec3u(round(share * held.within.{{ axes }})), used);
        {% endfor %}
        {% else %}
        sum = select(sum, vec3u(0u), next != cell) + rounded;
        {% endif %}
        cell = next;
        i++;
        if i >= steps { break; }
    }
    if cell != NOWHERE { scatter(cell, {{ all_sums }}); }
}
