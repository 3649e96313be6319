// Share of light that passes from a node to a point in a cell's middle, unit vector `towards` and `distance` away
// (simulator/lpv/geometry.py, `cone_transmittance`): the march goes on to the next level when it has doubled its
// length, and so never reaches the coarsest. `travelled` counts cells along the direction's longest component.
fn passing(point: vec3f, towards: vec3f, distance: f32, node_size: f32) -> f32 {
    let sizes = abs(towards);
    let is_x = sizes.x >= max(sizes.y, sizes.z);
    let is_y = sizes.y >= sizes.z;
    let along = select(select(point.z, point.y, is_y), point.x, is_x);
    let signed = select(select(towards.z, towards.y, is_y), towards.x, is_x);
    let longest = max(abs(signed), 1e-6);
    let sense = select(-1.0, 1.0, signed > 0.0);
    let size = sizes * ({{ 1 / 255 }} / longest);
    let last = distance * longest - max({{ left_out }}, 0.5 * node_size) - 0.25;
    var passed = select(0.0, 1.0, distance > 0.0);
    var travelled = 0.5;
    var width = 1.0;
    var bits = {{ bits }}u; // of a coordinate
    var first = 0u;
    loop {
        travelled -= width * fract((along + sense * travelled) / width); // back to a face of this level
        let limit = min(last, {{ 2 * cone_length }} * width * longest);
        let from_point = point * (1.0 / width);
        let ahead = towards * ({{ short }} / (width * longest));
        loop {
            let cell = vec3u(from_point + ahead * (travelled + 0.5 * width));
            let shares = geometry[first + (cell.x | (cell.y << bits) | (cell.z << (2u * bits)))];
            let blocked = dot(vec3f(vec3u(shares, shares >> 8u, shares >> 16u) & vec3u(255u)), size);
            passed *= 1.0 - select(0.0, min(blocked, 1.0), travelled < last);
            travelled += width;
            continuing { break if travelled >= limit || passed <= {{ opaque }}; }
        }
        first += 1u << (3u * bits);
        bits -= 1u;
        width *= 2.0;
        continuing { break if travelled >= last || passed <= {{ opaque }}; }
    }
    return passed;
}
