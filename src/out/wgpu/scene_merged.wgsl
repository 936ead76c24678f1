
// Draws of all tiles of instances. Needs no arrays in buffers.
struct SceneVertex {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec2<f32>,
    @location(2) tile: u32,
    @builtin(instance_index) place: u32,
};

// Colour and face of each tile of each instance.
@group(0) @binding(4) var scene_records: texture_2d<u32>;

fn scene_surface(vertex: SceneVertex) -> SceneSurface {
    let tile = textureLoad(scene_instances, scene_texel(vertex.place), 0).z + vertex.tile;
    let record = textureLoad(scene_records, scene_texel(tile), 0).xy;
    // OpenGL ES 3.0 has no function that unpacks.
    let colour = vec3<f32>((vec3(record.x) >> vec3(0u, 8u, 16u)) & vec3(255u)) / 255.0;
    return scene_surface_at(vertex.place, vertex.position, vertex.normal, colour, record.y, tile);
}
