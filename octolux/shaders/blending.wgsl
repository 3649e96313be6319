// The part that `one` has of what is read where it gives way to `other` by equal factors (simulator/blending.py).
fn moved_share(one: f32, other: f32, share: f32) -> f32 {
    let ratio = clamp(one / max(other, 1e-30), {{ 1 / blend_ratio }}, {{ blend_ratio }}.0);
    let even = abs(ratio - 1.0) < 1e-3 || share == 1.0;
    return select((pow(ratio, share) - 1.0) / (ratio - 1.0), share, even);
}
