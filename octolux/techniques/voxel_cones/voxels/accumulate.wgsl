// Sums what fragments bring to their voxels (simulator/voxels/surfaces.py), in fixed point: whole numbers may be added in
// any order. Of all voxels those from cube.first on that there is room for; those of what is static, in an octree of what
// moves, may be missing.
{{ use("shaders/surface.wgsl") }}
{{ use("techniques/voxel_cones/octree/leaves.wgsl") }}
{{ use("techniques/voxel_cones/voxels/fragments.wgsl") }}

// What alpha leaves of a fragment. The texture's mean says how much of a mask is there, if that is all or nothing at
// each texel.
fn coverage(alpha: f32, material: Material) -> f32 {
    let mask = select(0.0, alpha / max(material.alpha, 1e-6), material.alpha >= material.alpha_cutoff);
    return select(select(alpha, mask, material.alpha_mode == 1u), 1.0, material.alpha_mode == 0u);
}

fn add(place: u32, value: f32) {
    let whole = u32(round(value));
    if whole > 0u { atomicAdd(&sums[place], whole); }
}

// Of the three ways that the back of a surface across `along` looks in a voxel those, 1, that nothing covers: what moves is
// covered by what is static, but not the other way around.
fn seen_behind(voxel: vec3i, along: vec3f) -> vec3f {
    let behind = -vec3i(sign(along));
    let covered = vec3<bool>(
        found_at(voxel + vec3i(behind.x, 0, 0)).some, found_at(voxel + vec3i(0, behind.y, 0)).some,
        found_at(voxel + vec3i(0, 0, behind.z)).some,
    );
    return select(vec3f(1.0), vec3f(0.0), covered);
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let tile = id.x + {{ row }}u * id.y;
    if tile >= parameters.second { return; }
    let index = triangle_of(tile, parameters.count);
    let number = load_ids(index);
    let item = load_items(number >> CLUSTER_BITS);
    let corners = load_triangles(item.first_triangle + (number & ((1u << CLUSTER_BITS) - 1u)));
    let instance = load_instances(item.instance);
    let material = load_materials(instance.material);
    let a = load_vertices(corners.a);
    let b = load_vertices(corners.b);
    let c = load_vertices(corners.c);
    let p = to_world(instance, a.position);
    let p2 = to_world(instance, b.position);
    let p3 = to_world(instance, c.position);
    let t = projected(to_voxels(p), to_voxels(p2), to_voxels(p3));
    let n = cross(p2 - p, p3 - p);
    let outward = normalize(select(n, -n, instance.flipped == 1u));
    let steepest = max(max(abs(outward.x), abs(outward.y)), abs(outward.z));
    let along = outward / steepest;
    let uv1 = b.uv - a.uv;
    let uv2 = c.uv - a.uv;
    // As wide in uv as a column is there.
    let width = sqrt(abs((uv1.x * uv2.y - uv1.y * uv2.x) / t.normal.z)) * {{ texture_scale }};
    let footprint = log2_footprint(vec2f(width, 0.0), vec2f(0.0, width));
    let columns = tile_columns(columns_of(t), tile - load_starts(index));
    var at = vec2u(0u);
    loop {
        let column = columns.first + vec2i(at);
        let voxel = voxel_of(t, column);
        let met = covered(t, column);
        if met.samples > 0u && in_cube(voxel) {
            let leaf = leaf_at(voxel);
            let slot = leaf.number - cube.first;
            if leaf.node != NO_NODE && slot < cube.room {
                var back = vec3f(0.0);
                {% if not interior %}
                if material.double_sided == 1u {
                {% endif %}
                back = seen_behind(voxel, along) * abs(along);
                {% if not interior %}
                }
                {% endif %}
                let up = select(back, along, along > vec3f(0.0));
                let down = select(back, -along, along < vec3f(0.0));
                let w = met.weights;
                var color = vec4f(1.0);
                {% if vertex_colors %}
                color = (1.0 - w.x - w.y) * unpack_color(a.color) + w.x * unpack_color(b.color) + w.y * unpack_color(c.color);
                {% endif %}
                let uv = a.uv + w.x * uv1 + w.y * uv2;
                let hit = Hit(p, 0.0, outward, instance.material, outward, vec4f(1.0, 0.0, 0.0, 1.0), uv, footprint, color);
                let base = base_color(hit, material);
                var albedo = base.rgb * (1.0 - material_roughness_metallic(material, uv, footprint).y);
                {% if unlit %}
                if material.unlit == 1u { albedo = vec3f(0.0); }
                {% endif %}
                let share = {{ layer / samples**2 }} * f32(met.samples) * coverage(base.a, material);
                let area = share / steepest;
                let first = {{ words }}u * slot;
                {% for axis in "xyz" %}
                add(first + {{ 2 * loop.index0 }}u, share * up.{{ axis }});
                add(first + {{ 2 * loop.index0 + 1 }}u, share * down.{{ axis }});
                add(first + {{ 6 + loop.index0 }}u, area * saturate(albedo.{{ axis }}));
                {% endfor %}
                add(first + 9u, area);
                {% if emissive %}
                var emission = cube.emission_scale * area * material_emissive(material, uv, footprint);
                {% if unlit %}
                if material.unlit == 1u { emission = vec3f(0.0); }
                {% endif %}
                {% for axis in "xyz" %}
                add(first + {{ 10 + loop.index0 }}u, emission.{{ axis }});
                {% endfor %}
                {% endif %}
            }
        }
        at.x += 1u;
        let next = at.x == columns.size.x;
        at = select(at, vec2u(0u, at.y + 1u), next);
        if at.y >= columns.size.y { break; }
    }
}
