// The cell that holds a place, which is shifted along a unit vector by some cells: of {{ grids }} nested grids of n^3 cells, the
// finest first, the finest that holds it{% if every %}; or, of grid number `only` alone, that grid's{% endif %}. Cells of all grids lie behind one another.
const NOWHERE = 0xffffffffu;

// within: where it lies in the cell, from 0 to 1.
struct Held { cell: u32, within: vec3f }

fn held_in(grid: Grid, place: vec3f, shift: vec3f, first: u32) -> Held {
    let at = (place - grid.origin) / grid.cell_size + shift;
    let cell = vec3i(floor(at));
    let number = first + u32(cell.x) + grid.n * (u32(cell.y) + grid.n * u32(cell.z));
    return Held(select(NOWHERE, number, all(cell >= vec3i(0)) && all(cell < vec3i(i32(grid.n)))), fract(at));
}

fn held_by(only: u32, place: vec3f, shift: vec3f) -> Held {
    {% if every %}
    let grid = grids[only];
    return held_in(grid, place, shift, only * grid.n * grid.n * grid.n);
    {% else %}
    let cells = grids[0].n * grids[0].n * grids[0].n;
    var held = held_in(grids[{{ grids - 1 }}], place, shift, {{ grids - 1 }}u * cells);
    {% for i in range(grids - 1)|reverse %}
    let in_{{ i }} = held_in(grids[{{ i }}], place, shift, {{ i }}u * cells);
    held.cell = select(in_{{ i }}.cell, held.cell, in_{{ i }}.cell == NOWHERE);
    held.within = select(in_{{ i }}.within, held.within, in_{{ i }}.cell == NOWHERE);
    {% endfor %}
    return held;
    {% endif %}
}

// One over the cross section of a cell.
fn per_cross_section(cell: u32) -> f32 {
    let grid = cell / (grids[0].n * grids[0].n * grids[0].n);
    var size = grids[0].cell_size;
    {% for i in range(1, grids) %}
    size = select(size, grids[{{ i }}].cell_size, grid == {{ i }}u);
    {% endfor %}
    return 1.0 / (size * size);
}
