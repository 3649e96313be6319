// Test kernel: the shared samplers, one `mode` each.
{{ use("shaders/sampler.wgsl") }}
{{ use("shaders/sample_directions.wgsl") }}

fn triple(first: u32) -> vec3f { return vec3f(given[first], given[first + 1u], given[first + 2u]); }

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let thread = id.x + id.y * {{ row }}u;
    if thread >= {{ threads }}u { return; }
    {% if mode == "points" %}
    let i = 5u * thread;
    var random = start_sampler(vec2u(u32(given[i]), u32(given[i + 1u])), u32(given[i + 2u]), u32(given[i + 3u]));
    for (var pair = 0u; pair < u32(given[i + 4u]); pair++) { _ = next_2d(&random); }
    let found = next_2d(&random);
    {% elif mode == "cosine" %}
    let found = sample_cosine(vec2f(given[2u * thread], given[2u * thread + 1u]));
    {% elif mode == "triangle" %}
    let found = sample_triangle(vec2f(given[2u * thread], given[2u * thread + 1u]));
    {% elif mode == "basis" %}
    let n = triple(3u * thread);
    let basis = basis_of(n);
    let found = array<f32, 9>(basis.t.x, basis.t.y, basis.t.z, basis.b.x, basis.b.y, basis.b.z,
        length(from_basis(basis, into_basis(basis, n.zxy)) - n.zxy), basis.n.x - n.x, basis.n.y - n.y);
    {% else %}
    let i = 6u * thread;
    let found = sample_visible_half(triple(i), given[i + 3u], vec2f(given[i + 4u], given[i + 5u]));
    {% endif %}
    for (var k = 0u; k < {{ outputs }}u; k++) { result[{{ outputs }}u * thread + k] = found[k]; }
}
