// Light in the air, from cells' cubes of irradiance, for fog. Each pair of faces across an axis receives radiance by
// |w.axis|, and the mean of |x| + |y| + |z| over the sphere is 3/2: even light has exactly two thirds of what all six
// receive as its fluence, a beam along an axis two thirds of its own, one between all three axes 1.15 of it.
{{ use("techniques/lpv/storage_scale.wgsl") }}

fn volume_fluence(position: vec3f) -> vec3f {
    let grid = grids[{{ last }}];
    let place = 0.5 * (position - grid.origin) / grid.cell_size; // cells here are twice as large
    let inside = all(place >= vec3f(0.0)) && all(place <= vec3f({{ air_n }}.0));
    let middle = clamp(place, vec3f(0.5), vec3f({{ air_n - 0.5 }}));
    var sum = vec3f(0.0);
    {% for face in range(6) %}
    sum += textureSampleLevel(air_cube, air_sampler,
        (middle + vec3f(0.0, 0.0, {{ air_n * face }}.0)) * vec3f({{ 1 / air_n }}, {{ 1 / air_n }}, {{ 1 / (6 * air_n) }}), 0.0).rgb;
    {% endfor %}
    let area = 4.0 * grid.cell_size * grid.cell_size;
    return select(vec3f(0.0), sum * ({{ 2 / 3 }} / (area * storage_scale(peak[0]))), inside);
}

fn volume_step(position: vec3f) -> f32 { return 2.0 * grids[{{ last }}].cell_size; }
