// Where the levels of a full octree of {{ n }}^3 cells lie behind one another, the finest first.

fn edge_of(level: u32) -> u32 { return {{ n }}u >> level; }

// Cells of all finer levels: n^3 (1 + 1/8 + ...) up to the level's own.
fn first_of(level: u32) -> u32 {
    let edge = edge_of(level);
    return 8u * (({{ n**3 }}u - edge * edge * edge) / 7u);
}

fn number_of(level: u32, cell: vec3u) -> u32 {
    let edge = edge_of(level);
    return first_of(level) + cell.x + edge * (cell.y + edge * cell.z);
}
