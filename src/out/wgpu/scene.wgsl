// Tiles of a scene for shaders: where a vertex is, where its surface faces, its colour, and what it belongs to.
// Positions are millimetres along the world's axes, relative to the eye. Depth is reversed: 1 at the near plane.
// All names begin with `scene`, `Scene` or `SCENE`. Takes bind group 0 and the locations 0 to 4 of vertices.

// The camera of an upload.
struct SceneView {
    clip: mat4x4<f32>,           // world relative to the eye, to clip
    eye: vec4<f32>,              // towards the eye, unit; w is 1 in orthographic projection
    section: vec4<f32>,          // plane that cuts: unit normal towards what is cut away, distance along it; 0 0 0 1: none
    size: vec2<f32>,             // pixels
    near: f32,                   // distance of the near plane; 0 in orthographic projection
};

@group(0) @binding(0) var<uniform> scene_view: SceneView;
// Arrays are textures of this width, which vertex shaders read on every device.
const SCENE_WIDTH: u32 = 2048u;
// Three rows of a transform per placed instance.
@group(0) @binding(2) var scene_places: texture_2d<f32>;
// Instance, part, and number of the first tile, per placed instance.
@group(0) @binding(3) var scene_instances: texture_2d<u32>;

// A vertex of a surface, as `scene_surface` returns it.
struct SceneSurface {
    clip: vec4<f32>,             // by the camera of the upload
    position: vec3<f32>,
    normal: vec3<f32>,           // outwards, not of unit length
    colour: vec3<f32>,           // linear
    mirrored: bool,              // the instance is mirrored: front faces are clockwise
    instance: u32,               // in the scene
    part: u32,                   // in the model
    face: u32,                   // in the part
    tile: u32,                   // among the tiles of all instances
};

// Transform from part (relative to its centre) to world (relative to the eye), by rows.
struct ScenePlace {
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
};

fn scene_texel(index: u32) -> vec2<u32> {
    return vec2(index % SCENE_WIDTH, index / SCENE_WIDTH);
}

fn scene_place(number: u32) -> ScenePlace {
    let first = 3u * number;
    return ScenePlace(
        textureLoad(scene_places, scene_texel(first), 0),
        textureLoad(scene_places, scene_texel(first + 1u), 0),
        textureLoad(scene_places, scene_texel(first + 2u), 0),
    );
}

fn scene_placed(place: ScenePlace, position: vec3<f32>) -> vec3<f32> {
    let point = vec4(position, 1.0);
    return vec3(dot(place.x, point), dot(place.y, point), dot(place.z, point));
}

// Unit vector from a position towards the eye.
fn scene_to_eye(position: vec3<f32>) -> vec3<f32> {
    return select(normalize(-position), scene_view.eye.xyz, scene_view.eye.w > 0.5);
}

// How far a position is beyond the plane that cuts. Fragments above 0 are cut away.
fn scene_beyond(position: vec3<f32>) -> f32 {
    return dot(scene_view.section.xyz, position) - scene_view.section.w;
}

// sRGB to linear light.
fn scene_linear(srgb: vec3<f32>) -> vec3<f32> {
    return select(pow((srgb + 0.055) / 1.055, vec3(2.4)), srgb / 12.92, srgb <= vec3(0.04045));
}

// Decodes an octahedral direction.
fn scene_direction(square: vec2<f32>) -> vec3<f32> {
    let z = 1.0 - abs(square.x) - abs(square.y);
    let below = max(-z, 0.0);
    return vec3(square - select(vec2(below), vec2(-below), square < vec2(0.0)), z);
}

fn scene_surface_at(
    number: u32,
    position: vec3<f32>,
    square: vec2<f32>,
    srgb: vec3<f32>,
    face: u32,
    tile: u32,
) -> SceneSurface {
    let place = scene_place(number);
    let world = scene_placed(place, position);
    // Cofactors transform normals; mirroring placements need the opposite sign.
    let cofactors = mat3x3(
        cross(place.y.xyz, place.z.xyz),
        cross(place.z.xyz, place.x.xyz),
        cross(place.x.xyz, place.y.xyz),
    );
    let mirrored = dot(place.x.xyz, cofactors[0]) < 0.0;
    let normal = scene_direction(square) * cofactors * select(1.0, -1.0, mirrored);
    let owner = textureLoad(scene_instances, scene_texel(number), 0);
    return SceneSurface(
        scene_view.clip * vec4(world, 1.0), world, normal, scene_linear(srgb), mirrored, owner.x, owner.y, face, tile);
}
