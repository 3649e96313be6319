// In which of {{ windows }} nested windows, the finest first, light is read at a place (simulator/lpv/cascades.py, `weights`).

// share: how much of what is read comes from this window; the rest comes from the next.
struct Reading { window: u32, share: f32 }

// In cells of a window from its corner; moved by so many of its cells.
fn place_at(window: u32, position: vec3f, shift: vec3f) -> vec3f {
    let grid = grids[window];
    return (position - grid.origin) / grid.cell_size + shift;
}

fn held_at_all(position: vec3f) -> bool {
    let whole = place_at({{ windows - 1 }}u, position, vec3f(0.0));
    return all(whole >= vec3f(0.0)) && all(whole <= vec3f({{ n }}.0));
}

{% if windows > 1 %}
fn share_of(window: u32, place: vec3f) -> f32 {
    let room = min(place - windows[window].low, windows[window].high - place);
    return saturate(min(room.x, min(room.y, room.z)) * {{ 1 / transition }});
}
{% endif %}

fn reading_at(position: vec3f, shift: vec3f) -> Reading {
    var reading = Reading({{ windows - 1 }}u, 1.0);
    {% for i in range(windows - 1)|reverse %}
    let share_{{ i }} = share_of({{ i }}u, place_at({{ i }}u, position, shift));
    if share_{{ i }} > 0.0 { reading = Reading({{ i }}u, share_{{ i }}); }
    {% endfor %}
    return reading;
}
