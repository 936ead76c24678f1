
@vertex
fn lattice_vertex(
    @location(0) position: vec3<f32>,
    @location(2) place: u32,
    @location(7) cell: vec2<f32>,
) -> Ruled {
    return ruled(scene_place(place), position, cell);
}

@group(2) @binding(0) var<storage, read> vertices: array<vec4<f32>>;
@group(2) @binding(1) var<storage, read> indices: array<u32>;

// Where a tile's triangles are.
struct Drawn {
    @location(5) first_index: u32,    // top bit set: indices have four bytes
    @location(6) base_vertex: u32,
    @location(2) place: u32,
};

fn corner_of(drawn: Drawn, corner: u32) -> vec3<f32> {
    let at = (drawn.first_index & 0x7fffffffu) + corner;
    var index = 0u;
    if drawn.first_index >= 0x80000000u {
        index = indices[at];
    } else {
        index = (indices[at / 2u] >> (16u * (at % 2u))) & 0xffffu;
    }
    return scene_placed(scene_place(drawn.place), vertices[drawn.base_vertex + index].xyz);
}

// Six vertices per side of each triangle. Adjacent triangles both draw their common side.
@vertex
fn wire_vertex(@builtin(vertex_index) vertex: u32, drawn: Drawn) -> Line {
    let triangle = 3u * (vertex / 18u);
    let side = (vertex / 6u) % 3u;
    let first = corner_of(drawn, triangle + side);
    let last = corner_of(drawn, triangle + (side + 1u) % 3u);
    return strip(first, last, vertex % 6u, WIRE, WIRE_WIDTH);
}
