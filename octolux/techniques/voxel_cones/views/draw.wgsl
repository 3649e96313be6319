// Which voxel of a level, in which something faces any way, each pixel's ray meets first (Amanatides and Woo 1987): x, y, z, 10
// bits each; the way that the face looks through which the ray comes; and how far away it is, in voxels of the level.
{{ use("shaders/view.wgsl") }}
{{ use("techniques/voxel_cones/octree/octree.wgsl") }}

const CELLS = {{ 2 ** (depth - level) }};

fn is_there(cell: vec3u) -> bool {
    let node = node_of(code_of({{ depth - 1 - level }}u, cell >> vec3u(1u)));
    let corner = (cell.x & 1u) | ((cell.y & 1u) << 1u) | ((cell.z & 1u) << 2u);
    return node != NO_NODE && any(facing[select(8u * node + corner, 0u, node == NO_NODE)] != vec2u(0u));
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(met_out)) { return; }
    let ray = view_ray(views[0], vec2f(id.xy) + 0.5);
    let origin = (ray.origin - voxels_of.origin) / (voxels_of.size * {{ 2 ** level }}.0);
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
    var found = false;
    var distance = near;
    while near < far && all(cell >= vec3i(0)) && all(cell < vec3i(CELLS)) {
        found = is_there(vec3u(cell));
        if found { break; }
        axis = select(select(2u, 1u, next.y <= next.z), 0u, next.x <= min(next.y, next.z));
        let step = vec3<bool>(axis == 0u, axis == 1u, axis == 2u);
        distance = next[axis];
        cell += select(vec3i(0), onward, step);
        next += select(vec3f(0.0), between, step);
    }
    let way = 2u * axis + u32(select(select(forward.z, forward.y, axis == 1u), forward.x, axis == 0u));
    let at = vec3u(cell);
    let key = select({{ nothing }}u, at.x | (at.y << 10u) | (at.z << 20u), found);
    textureStore(met_out, id.xy, vec4u(key, way, bitcast<u32>(distance), 0u));
}
