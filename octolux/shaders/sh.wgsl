// Two-band real spherical harmonics, all positive, order (1, y, z, x); constants from simulator/sh.py.

const SH_Y0 = {{ sh_y0 }};
const SH_Y1 = {{ sh_y1 }};
const SH_COSINE_LOBE_0 = {{ sh_cosine_lobe_0 }};
const SH_COSINE_LOBE_1 = {{ sh_cosine_lobe_1 }};

fn sh_evaluate(c: vec4f, direction: vec3f) -> f32 {
    return c.x * SH_Y0 + dot(c.wyz, direction) * SH_Y1;
}

// Coefficients of max(0, d.w).
fn sh_cosine_lobe(d: vec3f) -> vec4f {
    return vec4f(SH_COSINE_LOBE_0, SH_COSINE_LOBE_1 * d.yzx);
}

// A function as a cosine lobe with `fraction` of the flux along `direction`, and the rest in all directions.
struct DominantLobe { flux: f32, fraction: f32, direction: vec3f }

fn sh_dominant_lobe(c: vec4f) -> DominantLobe {
    let band1 = c.wyz;
    let size = length(band1);
    let flux = c.x / SH_Y0;
    let lit = c.x > 0.0 && size > 0.0;
    let ratio = min(1.0, {{ sh_cosine_lobe_0 / sh_cosine_lobe_1 }} * size / c.x);
    return DominantLobe(flux, select(0.0, ratio, lit), select(vec3f(0.0), band1 / size, lit));
}
