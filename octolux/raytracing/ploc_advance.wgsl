// PLOC, step 4: how many clusters are left and how many nodes there are, for the next round.

@compute @workgroup_size(1)
fn main() {
    let sum = totals[(state[0].x + {{ block - 1 }}u) / {{ block }}u];
    state[0].x = sum.x;
    state[0].y += sum.y;
}
