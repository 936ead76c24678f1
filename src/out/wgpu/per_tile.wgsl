
// Draws of tiles, one by one. The instance index is the number of the record.

// Per-draw record of a tile of an instance.
struct Drawn {
    @location(2) first_index: u32,    // top bit set: indices have four bytes
    @location(3) base_vertex: u32,
    @location(4) place: u32,
    @location(5) colour: vec4<f32>,
};

@vertex
fn surface_vertex(
    @location(0) position: vec3<f32>,
    @location(1) square: vec2<f32>,
    drawn: Drawn,
    @builtin(instance_index) number: u32,
) -> Surface {
    return surface(place_of(drawn.place), position, square, drawn.colour.rgb, number);
}

@vertex
fn lattice_vertex(
    @location(0) position: vec3<f32>,
    drawn: Drawn,
    @location(6) cell: vec2<f32>,
) -> Ruled {
    return ruled(place_of(drawn.place), position, cell);
}

@group(2) @binding(0) var<storage, read> vertices: array<vec4<f32>>;
@group(2) @binding(1) var<storage, read> indices: array<u32>;

fn corner_of(drawn: Drawn, corner: u32) -> vec3<f32> {
    let at = (drawn.first_index & 0x7fffffffu) + corner;
    var index = 0u;
    if drawn.first_index >= 0x80000000u {
        index = indices[at];
    } else {
        index = (indices[at / 2u] >> (16u * (at % 2u))) & 0xffffu;
    }
    return placed(place_of(drawn.place), vertices[drawn.base_vertex + index].xyz);
}

// Six vertices per side of each triangle. Adjacent triangles both draw their common side.
@vertex
fn wire_vertex(@builtin(vertex_index) vertex: u32, drawn: Drawn) -> Line {
    let triangle = 3u * (vertex / 18u);
    let side = (vertex / 6u) % 3u;
    let first = corner_of(drawn, triangle + side);
    let last = corner_of(drawn, triangle + (side + 1u) % 3u);
    return strip(first, last, vertex % 6u, globals.wire, globals.wire_width);
}
