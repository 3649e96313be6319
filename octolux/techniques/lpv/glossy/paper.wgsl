// CLPV 7 by the letter: the mean of I(-r) over the square of the distance in a few cells along the direction
// (simulator/lpv/glossy.py, `paper_light`), times the square of level 0's cell size.
{{ use("shaders/sh.wgsl") }}
{{ use("techniques/lpv/texel.wgsl") }}

fn incident(point: vec3f, towards: vec3f, base: u32, cone: f32, wanted: bool) -> vec3f {
    let width = f32(1u << base);
    {% if windows > 1 %}
    var origin = vec3f(windows[0].origin);
    {% for i in range(1, windows) %}
    origin = select(origin, vec3f(windows[{{ i }}].origin), base == {{ i }}u);
    {% endfor %}
    {% else %}
    let origin = vec3f(0.0);
    {% endif %}
    var sum = vec3f(0.0);
    for (var k = 1u; k <= {{ cells }}u; k++) {
        let at = texel_at(base, point / width - origin + f32(k) * towards);
        let found = vec3f(
            {% for channel in ("red", "green", "blue") %}
            max(0.0, sh_evaluate(textureSampleLevel({{ channel }}, volume_sampler, at, 0.0), -towards)),
            {% endfor %}
        );
        sum += found * (1.0 / f32(k * k));
    }
    return select(vec3f(0.0), sum * ({{ 1 / cells }} / (width * width)), wanted);
}
