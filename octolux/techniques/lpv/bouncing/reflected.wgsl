// What the surfaces of a cell send back (simulator/lpv/bouncing.py): of irradiance on its six faces times the square of a cell
// size, the flux that they receive and reflect, as a cosine lobe along each face's normal.
{{ use("shaders/sh.wgsl") }}
{{ use("techniques/lpv/bouncing/cube.wgsl") }}

struct Light { red: vec4f, green: vec4f, blue: vec4f } // order 1, y, z, x

fn reflected(cell: u32, cube: Cube) -> Light {
    let xy = reflectors[3u * cell];
    let z = reflectors[3u * cell + 1u];
    let albedo = reflectors[3u * cell + 2u].rgb;
    let up = mat3x3f(xy.x * albedo * cube.x[0], xy.z * albedo * cube.y[0], z.x * albedo * cube.z[0]);
    let down = mat3x3f(xy.y * albedo * cube.x[1], xy.w * albedo * cube.y[1], z.y * albedo * cube.z[1]);
    let flux = up[0] + up[1] + up[2] + down[0] + down[1] + down[2];
    let along = up - down;
    var light: Light;
    {% for channel in ("red", "green", "blue") %}
    {% set c = loop.index0 %}
    light.{{ channel }} = {{ 1 / pi }} * vec4f({{ sh_cosine_lobe_0 }} * flux[{{ c }}],
        {{ sh_cosine_lobe_1 }} * vec3f(along[1][{{ c }}], along[2][{{ c }}], along[0][{{ c }}]));
    {% endfor %}
    return light;
}
