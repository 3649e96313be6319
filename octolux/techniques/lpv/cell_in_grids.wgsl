// The cell of grid number `number` of {{ grids }} of n^3 cells that holds a place, which is shifted along a unit vector by some of its
// cells. Cells of all grids lie behind one another.
const NOWHERE = 0xffffffffu;

// within: where the shifted place lies in the cell, from 0 to 1.  unshifted: where the place itself does, from the cell's corner.
struct Held { cell: u32, within: vec3f, unshifted: vec3f }

fn held_by(number: u32, place: vec3f, shift: vec3f) -> Held {
    let grid = grids[number];
    let at = (place - grid.origin) / grid.cell_size + shift;
    let cell = vec3i(floor(at));
    let in_grid = u32(cell.x) + grid.n * (u32(cell.y) + grid.n * u32(cell.z));
    let inside = all(cell >= vec3i(0)) && all(cell < vec3i(i32(grid.n)));
    return Held(select(NOWHERE, number * grid.n * grid.n * grid.n + in_grid, inside), fract(at), fract(at) - shift);
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
