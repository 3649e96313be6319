// The cube of irradiance times a cell's area at a cell of the last window, as gathering has left it.
{{ use("techniques/lpv/storage_scale.wgsl") }}

struct Cube { x: mat2x3f, y: mat2x3f, z: mat2x3f } // towards the upper and the lower end of each axis

fn gathered(cell: vec3u, factor: vec3f) -> Cube {
    {% for face in range(6) %}
    let face_{{ face }} = factor * textureLoad(cube, cell + vec3u(0u, 0u, {{ face * n }}u), 0).rgb / storage_scale(peak[0]);
    {% endfor %}
    return Cube(mat2x3f(face_0, face_1), mat2x3f(face_2, face_3), mat2x3f(face_4, face_5));
}
