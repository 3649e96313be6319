// Columns of voxels along the axis nearest to a normal (simulator/voxels/fragments.py): two axes across, then the one along.

fn dominant_axis(normal: vec3f) -> u32 {
    let size = abs(normal) * vec3f(1.0, {{ 1 - bias }}, {{ 1 - 2 * bias }});
    return select(select(2u, 1u, size.y >= size.z), 0u, size.x >= max(size.y, size.z));
}

fn turned(p: vec3f, axis: u32) -> vec3f { return select(select(p, p.zxy, axis == 1u), p.yzx, axis == 0u); }
fn turned_integers(p: vec3i, axis: u32) -> vec3i { return select(select(p, p.zxy, axis == 1u), p.yzx, axis == 0u); }
fn turned_back(p: vec3i, axis: u32) -> vec3i { return select(select(p, p.yzx, axis == 1u), p.zxy, axis == 0u); }

fn to_voxels(p: vec3f) -> vec3f { return (p - cube.low) * cube.scale; }
