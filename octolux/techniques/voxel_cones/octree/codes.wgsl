// Codes of an octree's cells (Warren and Salmon 1993): the Morton code of a cell behind a leading 1. The cells of a level
// with 2^k along each side have the codes from 8^k; the parent of `code` is code >> 3, its children are 8 code + corner.
// A node of level i and the voxel of level i + 1 that is made of it have the same code.

fn spread_bits(x: u32) -> u32 {
    var b = (x | (x << 16u)) & 0x030000ffu;
    b = (b | (b << 8u)) & 0x0300f00fu;
    b = (b | (b << 4u)) & 0x030c30c3u;
    return (b | (b << 2u)) & 0x09249249u;
}

fn gathered_bits(x: u32) -> u32 {
    var b = x & 0x09249249u;
    b = (b | (b >> 2u)) & 0x030c30c3u;
    b = (b | (b >> 4u)) & 0x0300f00fu;
    b = (b | (b >> 8u)) & 0x030000ffu;
    return (b | (b >> 16u)) & 0x3ffu;
}

// log2_edge: k of a level with 2^k cells along each side.
fn code_of(log2_edge: u32, cell: vec3u) -> u32 {
    let morton = spread_bits(cell.x) | (spread_bits(cell.y) << 1u) | (spread_bits(cell.z) << 2u);
    return (1u << (3u * log2_edge)) | morton;
}

fn log2_edge_of(code: u32) -> u32 { return firstLeadingBit(code) / 3u; }

fn cell_of(code: u32) -> vec3u {
    let morton = code & ((1u << (3u * log2_edge_of(code))) - 1u);
    return vec3u(gathered_bits(morton), gathered_bits(morton >> 1u), gathered_bits(morton >> 2u));
}
