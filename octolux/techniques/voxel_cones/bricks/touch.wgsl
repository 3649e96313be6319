// Lists of what is to be made anew: of each level its nodes, one segment of `node_list` after the other from level 0, and, last,
// bricks. Of each list `lists` says how many threads work on it, as arguments of a dispatch, and its length. They come in any
// order: no result depends on it. `touched`: bits of each node, 1: it is in a list; 2: its bricks are.
const GROUPS = {{ row // 64 }}u; // of threads, along x

fn need_threads(list: u32, count: u32) {
    let groups = (count + 63u) / 64u;
    atomicMax(&lists[4u * list], min(groups, GROUPS));
    atomicMax(&lists[4u * list + 1u], (groups + GROUPS - 1u) / GROUPS);
}

// The place of the first of `count` elements that are added.
fn longer(list: u32, count: u32) -> u32 { return atomicAdd(&lists[4u * list + 3u], count); }

// begin: of the level's segment.
fn touch(node: u32, level: u32, begin: u32) {
    if (atomicOr(&touched[node], 1u) & 1u) != 0u { return; }
    let place = longer(level, 1u);
    node_list[begin + place] = node;
    need_threads(level, 8u * (place + 1u));
}
