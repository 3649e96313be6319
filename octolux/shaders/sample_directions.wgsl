// Random directions and their densities (per sr); references and chi-square tests: tests/kernels/test_samplers.py.

// Two unit vectors that stand on unit vector n (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
struct Basis { t: vec3f, b: vec3f, n: vec3f }

fn basis_of(n: vec3f) -> Basis {
    let side = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (side + n.z);
    let b = n.x * n.y * a;
    return Basis(vec3f(1.0 + side * n.x * n.x * a, side * b, -side * n.x), vec3f(b, side + n.y * n.y * a, -n.y), n);
}

fn from_basis(basis: Basis, v: vec3f) -> vec3f { return v.x * basis.t + v.y * basis.b + v.z * basis.n; }
fn into_basis(basis: Basis, v: vec3f) -> vec3f { return vec3f(dot(v, basis.t), dot(v, basis.b), dot(v, basis.n)); }

// Density cos / pi around +z.
fn sample_cosine(u: vec2f) -> vec3f {
    let radius = sqrt(u.x);
    let angle = {{ 2 * pi }} * u.y;
    return vec3f(radius * cos(angle), radius * sin(angle), sqrt(max(1.0 - u.x, 0.0)));
}

// A half vector among those that unit vector v (v.z > 0) sees of a GGX surface: density D_v(h) = G1(v) max(0, v.h) D(h) / v.z
// (Heitz 2018, "Sampling the GGX Distribution of Visible Normals").
fn sample_visible_half(v: vec3f, alpha: f32, u: vec2f) -> vec3f {
    let stretched = normalize(vec3f(alpha * v.xy, v.z));
    let square = dot(stretched.xy, stretched.xy);
    let t1 = select(vec3f(1.0, 0.0, 0.0), vec3f(-stretched.y, stretched.x, 0.0) * inverseSqrt(max(square, 1e-20)), square > 1e-12);
    let t2 = cross(stretched, t1);
    let radius = sqrt(u.x);
    let angle = {{ 2 * pi }} * u.y;
    let p1 = radius * cos(angle);
    let s = 0.5 * (1.0 + stretched.z);
    let p2 = (1.0 - s) * sqrt(max(1.0 - p1 * p1, 0.0)) + s * radius * sin(angle);
    let h = p1 * t1 + p2 * t2 + sqrt(max(1.0 - p1 * p1 - p2 * p2, 0.0)) * stretched;
    return normalize(vec3f(alpha * h.xy, max(h.z, 0.0)));
}

fn ggx_density(n_h: f32, alpha: f32) -> f32 {
    let square = alpha * alpha;
    let spread = n_h * n_h * (square - 1.0) + 1.0;
    return square / ({{ pi }} * spread * spread);
}

// Density of the direction that v is mirrored to at a sampled half vector h: D_v(h) / (4 v.h) = D(h) G1(v) / (4 n.v), where
// G1 = 2 n.v / (n.v + sqrt(alpha^2 + (1 - alpha^2) n.v^2)).
fn visible_density(n_h: f32, n_v: f32, alpha: f32) -> f32 {
    let square = alpha * alpha;
    return 0.5 * ggx_density(n_h, alpha) / (n_v + sqrt(square + (1.0 - square) * n_v * n_v));
}

// Weights of the second and third corner of an even point of a triangle (Turk 1990, "Generating Random Points in Triangles").
fn sample_triangle(u: vec2f) -> vec2f { return sqrt(u.x) * vec2f(1.0 - u.y, u.y); }
