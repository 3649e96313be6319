// Stored numbers are W/sr times 2^e, e such that the largest injected band-0 coefficient comes to lie in [8, 16).
// Half floats then hold everything from 4e-9 of that peak up to 4096 times of it. A step does not focus light: the most
// a cell can gain is six neighbours that all face it, 6 * 0.58 times the peak, once; so 256 steps fit with room.

fn storage_scale(peak_bits: u32) -> f32 {
    if peak_bits == 0u { return 1.0; }
    return exp2(clamp(3.0 - floor(log2(bitcast<f32>(peak_bits))), -126.0, 126.0)); // a normal number, whatever the peak
}
