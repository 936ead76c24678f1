
@vertex
fn lattice_vertex(
    @location(0) position: vec3<f32>,
    @location(7) cell: vec2<f32>,
    @builtin(instance_index) place: u32,
) -> Ruled {
    return ruled(scene_place(place), position, cell);
}

// One end of a side of a triangle, drawn as a line of one pixel.
@vertex
fn wire_vertex(@location(0) position: vec3<f32>, @builtin(instance_index) place: u32) -> Line {
    let world = scene_placed(scene_place(place), position);
    var clip = scene_view.clip * vec4(world, 1.0);
    clip.z = clip.z * style.nearer.x + style.nearer.y;
    return Line(clip, vec4(scene_linear(WIRE.rgb), WIRE.a), scene_beyond(world));
}
