// Where an octree's leaves lie when nothing else is stored (simulator/lpv/sparse.py). The eight children of a split cell
// are a brick: slots side by side, x quickest. The slot of a child that is split itself stays empty.
{{ use("techniques/lpv/octree/addresses.wgsl") }}

struct Node { level: u32, cell: vec3u }

// Split cells are of level 1 and above.
fn split_number(level: u32, cell: vec3u) -> u32 { return number_of(level, cell) - {{ n**3 }}u; }

fn corner_of(cell: vec3u) -> u32 { return (cell.x & 1u) | ((cell.y & 1u) << 1u) | ((cell.z & 1u) << 2u); }

fn pack_brick(level: u32, parent: vec3u) -> u32 { return (level << 21u) | (parent.z << 14u) | (parent.y << 7u) | parent.x; }

{% if "bricks" in reads %}
fn node_of(slot: u32) -> Node {
    let packed = bricks[slot >> 3u];
    let parent = vec3u(packed, packed >> 7u, packed >> 14u) & vec3u(127u);
    return Node(packed >> 21u, 2u * parent + (vec3u(slot, slot >> 1u, slot >> 2u) & vec3u(1u)));
}
{% endif %}

{% if "brick_numbers" in reads %}
// The brick of a cell's children, counted from 1; 0 where it has none.
fn children_of(level: u32, cell: vec3u) -> u32 {
    if level == 0u { return 0u; }
    return brick_numbers[split_number(level, cell)];
}

fn slot_in(brick: u32, cell: vec3u) -> u32 { return 8u * (brick - 1u) + corner_of(cell); }

struct Leaf { level: u32, slot: u32 }

// The leaf that covers a cell of level 0. The root is always split. Unrolled: Mesa 22's software adapter leaves a later loop
// after one round when a `while` came before it that threads left at different times.
fn leaf_of(cell: vec3u) -> Leaf {
    var level = 0u;
    var brick = children_of(1u, cell >> vec3u(1u));
    {% for level in range(1, depth - 1) %}
    if brick == 0u {
        level = {{ level }}u;
        brick = children_of({{ level + 1 }}u, cell >> vec3u({{ level + 1 }}u));
    }
    {% endfor %}
    return Leaf(level, slot_in(brick, cell >> vec3u(level)));
}

// The leaf that covers a cell of `level`, and is of that level or at most two above.
fn leaf_near(level: u32, cell: vec3u) -> Leaf {
    let parent = cell >> vec3u(1u);
    let own = children_of(level + 1u, parent);
    if own != 0u { return Leaf(level, slot_in(own, cell)); }
    let grandparent = cell >> vec3u(2u);
    let next = children_of(level + 2u, grandparent);
    if next != 0u { return Leaf(level + 1u, slot_in(next, parent)); }
    return Leaf(level + 2u, slot_in(children_of(level + 3u, cell >> vec3u(3u)), grandparent));
}
{% endif %}
