// A surfel's share of the cross sections of the cell that it lies in (simulator/lpv/geometry.py).

fn add_surfel(position: vec3f, normal: vec3f, area: f32) {
    let cell = vec3i(floor((position - grid.origin) / grid.cell_size));
    if any(cell < vec3i(0)) || any(cell >= vec3i(i32(grid.n))) { return; }
    let first = 3u * (u32(cell.x) + grid.n * (u32(cell.y) + grid.n * u32(cell.z)));
    let share = min(vec3f(1.0), abs(normal) * (area / (grid.cell_size * grid.cell_size)));
    let fixed = vec3u(round(share * {{ one }}.0));
    {% for k in range(3) %}
    if fixed[{{ k }}] > 0u && atomicLoad(&sums[first + {{ k }}u]) < {{ one }}u {
        atomicAdd(&sums[first + {{ k }}u], fixed[{{ k }}]);
    }
    {% endfor %}
}
