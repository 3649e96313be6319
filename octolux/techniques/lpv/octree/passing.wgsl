// Share of light that passes from a node to a point, unit vector `towards` and `distance` away (simulator/lpv/geometry.py,
// `cone_transmittance`): the march goes on to the next level each time that it has doubled its length, and so never
// reaches the coarsest.
fn passing(point: vec3f, towards: vec3f, distance: f32, node_size: f32) -> f32 {
    let per_layer = 1.0 / max(max(abs(towards.x), abs(towards.y)), max(abs(towards.z), 1e-6));
    let size = abs(towards) * (per_layer * {{ 1 / 255 }});
    let last = distance - max(1.0, 0.5 * node_size) * per_layer;
    var passed = select(0.0, 1.0, distance > 0.0);
    var travelled = per_layer;
    var width = 1.0;
    var bits = {{ bits }}u; // of a coordinate
    var first = 0u;
    loop {
        let step = width * per_layer;
        let limit = min(last, {{ 2 * cone_length }} * width);
        let from_point = point * (1.0 / width);
        let ahead = towards * (1.0 / width);
        loop {
            let cell = vec3u(from_point + ahead * (travelled + 0.5 * step));
            let shares = geometry[first + (cell.x | (cell.y << bits) | (cell.z << (2u * bits)))];
            let blocked = dot(vec3f(vec3u(shares, shares >> 8u, shares >> 16u) & vec3u(255u)), size);
            passed *= 1.0 - select(0.0, min(blocked, 1.0), travelled < last);
            travelled += step;
            continuing { break if travelled >= limit || passed <= {{ opaque }}; }
        }
        first += 1u << (3u * bits);
        bits -= 1u;
        width *= 2.0;
        continuing { break if travelled >= last || passed <= {{ opaque }}; }
    }
    return passed;
}
