// The cell that holds a place, which is shifted along a unit vector by some cells: of {{ grids }} nested grids of n^3 cells, the
// finest first, the finest that holds it{% if every %}; or, of grid number `only` alone, that grid's{% endif %}. Cells of all grids lie behind one another.
const NOWHERE = 0xffffffffu;

fn cell_in(grid: Grid, place: vec3f, shift: vec3f, first: u32) -> u32 {
    let cell = vec3i(floor((place - grid.origin) / grid.cell_size + shift));
    let number = first + u32(cell.x) + grid.n * (u32(cell.y) + grid.n * u32(cell.z));
    return select(NOWHERE, number, all(cell >= vec3i(0)) && all(cell < vec3i(i32(grid.n))));
}
{% if every %}

fn cell_of_grid(only: u32, place: vec3f, shift: vec3f) -> u32 {
    let grid = grids[only];
    return cell_in(grid, place, shift, only * grid.n * grid.n * grid.n);
}
{% else %}

fn finest_cell(place: vec3f, shift: vec3f) -> u32 {
    var cell = NOWHERE;
    {% for i in range(grids)|reverse %}
    let cell_{{ i }} = cell_in(grids[{{ i }}], place, shift, {{ i }}u * grids[{{ i }}].n * grids[{{ i }}].n * grids[{{ i }}].n);
    cell = select(cell_{{ i }}, cell, cell_{{ i }} == NOWHERE);
    {% endfor %}
    return cell;
}
{% endif %}
