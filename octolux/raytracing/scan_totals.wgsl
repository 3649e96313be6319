// Exclusive prefix sums of the blocks' totals, in place, by one thread each for a run of blocks; behind them the sum of all.
var<workgroup> partial: array<{{ element }}, 256>;

@compute @workgroup_size(256, 1, 1)
fn main(@builtin(local_invocation_index) lane: u32) {
    let blocks = (parameters.count + {{ block - 1 }}u) / {{ block }}u;
    let run = (blocks + 255u) / 256u;
    let first = lane * run;
    let end = min(first + run, blocks);
    var sum = {{ element }}();
    for (var i = first; i < end; i++) { sum += totals[i]; }
    partial[lane] = sum;
    workgroupBarrier();
    if lane == 0u {
        var all = {{ element }}();
        for (var k = 0u; k < 256u; k++) {
            let value = partial[k];
            partial[k] = all;
            all += value;
        }
        totals[blocks] = all;
    }
    workgroupBarrier();
    var before = partial[lane];
    for (var i = first; i < end; i++) {
        let value = totals[i];
        totals[i] = before;
        before += value;
    }
}
