// Which cell of a level each pixel's ray meets first (Amanatides and Woo 1987): with `nodes` a node, of which the number is that
// of the node; else a voxel in which something faces any way, 8 times its node's number and its corner. And the way that
// the face looks through which the ray comes.
{{ use("shaders/view.wgsl") }}
{{ use("techniques/voxel_cones/octree.wgsl") }}

const CELLS = {{ 2 ** (depth - level - nodes) }};

fn number_of(cell: vec3u) -> u32 {
    {% if nodes %}
    return node_of(code_of({{ depth - 1 - level }}u, cell));
    {% else %}
    let node = node_of(code_of({{ depth - 1 - level }}u, cell >> vec3u(1u)));
    let number = 8u * node + ((cell.x & 1u) | ((cell.y & 1u) << 1u) | ((cell.z & 1u) << 2u));
    let there = node != NO_NODE && any(facing[select(number, 0u, node == NO_NODE)] != vec2u(0u));
    return select(NO_NODE, number, there);
    {% endif %}
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(met_out)) { return; }
    let ray = view_ray(views[0], vec2f(id.xy) + 0.5);
    let origin = (ray.origin - voxels_of.origin) / (voxels_of.size * {{ 2 ** (level + nodes) }}.0);
    let towards = normalize(ray.direction);
    let steep = select(vec3f(1e-12), towards, abs(towards) > vec3f(1e-12));
    let forward = steep > vec3f(0.0);
    let enters = (select(vec3f(f32(CELLS)), vec3f(0.0), forward) - origin) / steep;
    let leaves = (select(vec3f(0.0), vec3f(f32(CELLS)), forward) - origin) / steep;
    let near = max(max(enters.x, max(enters.y, enters.z)), 0.0);
    let far = min(leaves.x, min(leaves.y, leaves.z));
    var axis = select(select(2u, 1u, enters.y >= enters.z), 0u, enters.x >= max(enters.y, enters.z));
    var cell = clamp(vec3i(floor(origin + near * steep)), vec3i(0), vec3i(CELLS - 1));
    var next = (vec3f(cell) + select(vec3f(0.0), vec3f(1.0), forward) - origin) / steep;
    let between = abs(1.0 / steep);
    let onward = select(vec3i(-1), vec3i(1), forward);
    var number = NO_NODE;
    while near < far && all(cell >= vec3i(0)) && all(cell < vec3i(CELLS)) {
        number = number_of(vec3u(cell));
        if number != NO_NODE { break; }
        axis = select(select(2u, 1u, next.y <= next.z), 0u, next.x <= min(next.y, next.z));
        let step = vec3<bool>(axis == 0u, axis == 1u, axis == 2u);
        cell += select(vec3i(0), onward, step);
        next += select(vec3f(0.0), between, step);
    }
    let way = 2u * axis + u32(select(select(forward.z, forward.y, axis == 1u), forward.x, axis == 0u));
    textureStore(met_out, id.xy, vec4u(number, way, 0u, 0u));
}
