
// Draws of tiles, one by one.
struct SceneVertex {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec2<f32>,
    @location(2) place: u32,
    @location(3) colour: vec4<f32>,
    @location(4) face: u32,
    @builtin(instance_index) tile: u32,
};

fn scene_surface(vertex: SceneVertex) -> SceneSurface {
    return scene_surface_at(
        vertex.place, vertex.position, vertex.normal, vertex.colour.rgb, vertex.face, vertex.tile);
}
