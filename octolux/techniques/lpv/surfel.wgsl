// Surfels' shares of the cross sections of the cells that they lie in (simulator/lpv/geometry.py), in fixed point.
//
// A thread walks down {{ run }} surfels of a map's column and adds up their shares while they lie in one cell. Three numbers
// are few enough to be scattered in the loop, unlike inject.wgsl's twelve: no thread waits for another that has met a new
// cell. Each surfel is rounded by itself, so the sums have the same bits however the walks are cut.

struct Surfel { position: vec3f, normal: vec3f, area: f32 } // no area: nothing is there
{{ use("techniques/lpv/cell_in_grids.wgsl") }}

// One over the cross section of a cell.
fn per_cross_section(cell: u32) -> f32 {
    let of_level = cell / (grids[0].n * grids[0].n * grids[0].n);
    var size = grids[0].cell_size;
    {% for i in range(1, grids) %}
    size = select(size, grids[{{ i }}].cell_size, of_level == {{ i }}u);
    {% endfor %}
    return 1.0 / (size * size);
}

// A walk that brings a whole wall closes the cell: more would only come nearer to 2^32.
fn add_shares(cell: u32, sum: vec3u) {
    let at = 3u * (surfels.sums + cell);
    let shares = min(sum, vec3u({{ one }}u));
    {% for k in range(3) %}
    if shares[{{ k }}] > 0u && atomicLoad(&sums[at + {{ k }}u]) < {{ one }}u {
        atomicAdd(&sums[at + {{ k }}u], shares[{{ k }}]);
    }
    {% endfor %}
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let start = id.x / surfels.width * ({{ run }}u * surfels.width) + id.x % surfels.width;
    if start >= surfels.count { return; }
    let steps = min({{ run }}u, (surfels.count - 1u - start) / surfels.width + 1u);
    var i = 0u;
    var cell = NOWHERE;
    var sum = vec3u(0u);
    loop {
        let surfel = surfel_at(start + i * surfels.width);
        let held_by = {{ "cell_of_grid(id.y, " if every else "finest_cell(" }}surfel.position, {{ -behind }} * surfel.normal);
        let used = surfel.area > 0.0 && held_by != NOWHERE;
        let next = select(cell, held_by, used);
        let share = min(vec3f(1.0), abs(surfel.normal) * (surfel.area * per_cross_section(held_by)));
        let fixed = select(vec3u(0u), vec3u(round(share * {{ one }}.0)), used);
        if next != cell && cell != NOWHERE { add_shares(cell, sum); }
        sum = select(sum, vec3u(0u), next != cell) + fixed;
        cell = next;
        i++;
        if i >= steps { break; }
    }
    if cell != NOWHERE { add_shares(cell, sum); }
}
