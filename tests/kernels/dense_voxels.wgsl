// Voxels without an octree, for cones: the six ways of simulator/voxels/facing.py side by side, radiance times facing and
// facing, levels as mip levels.

fn against(position: vec3f, level: u32, direction: vec3f) -> array<vec4f, 3> {
    let edge = {{ 2 ** depth }}.0 / f32(1u << level);
    let at = clamp(position / f32(1u << level), vec3f(0.5), vec3f(edge - 0.5)) / edge;
    var found: array<vec4f, 3>;
    {% for axis in "xyz" %}
    {
        let way = select({{ 2 * loop.index0 }}.0, {{ 2 * loop.index0 + 1 }}.0, direction.{{ axis }} > 0.0);
        let place = vec3f((way + at.x) / 6.0, at.yz);
        found[{{ loop.index0 }}] = abs(direction.{{ axis }}) * textureSampleLevel(facing_volume, facing_sampler, place, f32(level));
    }
    {% endfor %}
    return found;
}

fn sample_voxels(position: vec3f, level: u32, direction: vec3f) -> vec4f {
    let found = against(position, level, direction);
    return found[0] + found[1] + found[2];
}

fn facing_voxels(position: vec3f, level: u32, direction: vec3f) -> vec3f {
    let found = against(position, level, direction);
    return vec3f(found[0].a, found[1].a, found[2].a);
}

fn is_empty(position: vec3f, level: u32) -> bool {
    let last = i32({{ 2 ** depth }}u >> level) - 1;
    let cell = vec3i(floor((position / f32(1u << level) - 0.5) * 0.5));
    var most = 0.0;
    {% for way in range(6) %}{% for z in range(3) %}{% for y in range(3) %}{% for x in range(3) %}
    {
        let voxel = clamp(2 * cell + vec3i({{ x }}, {{ y }}, {{ z }}), vec3i(0), vec3i(last));
        most = max(most, textureLoad(facing_volume, voxel + vec3i({{ way }} * (last + 1), 0, 0), i32(level)).a);
    }
    {% endfor %}{% endfor %}{% endfor %}{% endfor %}
    return most == 0.0;
}
