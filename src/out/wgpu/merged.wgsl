
// Draws of all tiles of an instance. The instance index is the place. Needs no arrays in buffers.

// Colours of tiles by the number of their record, and the first number of each place.
@group(3) @binding(0) var colours: texture_2d<f32>;
@group(3) @binding(1) var firsts: texture_2d<u32>;

@vertex
fn surface_vertex(
    @location(0) position: vec3<f32>,
    @location(1) square: vec2<f32>,
    @location(7) tile: u32,
    @builtin(instance_index) place: u32,
) -> Surface {
    let number = textureLoad(firsts, texel(place), 0).x + tile;
    let colour = textureLoad(colours, texel(number), 0).rgb;
    return surface(place_of(place), position, square, colour, number);
}

@vertex
fn lattice_vertex(
    @location(0) position: vec3<f32>,
    @location(6) cell: vec2<f32>,
    @builtin(instance_index) place: u32,
) -> Ruled {
    return ruled(place_of(place), position, cell);
}

// One end of a side of a triangle, drawn as a line of one pixel.
@vertex
fn wire_vertex(@location(0) position: vec3<f32>, @builtin(instance_index) place: u32) -> Line {
    var clip = globals.clip * vec4(placed(place_of(place), position), 1.0);
    clip.z = clip.z * globals.nearer.x + globals.nearer.y;
    return Line(clip, vec4(linear(globals.wire.rgb), globals.wire.a));
}
