// Draws the panel's triangles. Their colours are egui's: gamma-encoded sRGB with premultiplied alpha.

struct Globals {
    size: vec2<f32>,     // points
    encoded: f32,        // 1: the target stores encoded sRGB as written
    rest: f32,
};

@group(0) @binding(0) var<uniform> globals: Globals;
@group(1) @binding(0) var image: texture_2d<f32>;
@group(1) @binding(1) var nearby: sampler;

struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) at: vec2<f32>,
    @location(1) colour: vec4<f32>,
};

@vertex
fn vertex(@location(0) place: vec2<f32>, @location(1) at: vec2<f32>, @location(2) colour: vec4<f32>) -> Corner {
    let clip = vec2(2.0 * place.x / globals.size.x - 1.0, 1.0 - 2.0 * place.y / globals.size.y);
    return Corner(vec4(clip, 0.0, 1.0), at, colour);
}

fn linear(srgb: vec3<f32>) -> vec3<f32> {
    return select(pow((srgb + 0.055) / 1.055, vec3(2.4)), srgb / 12.92, srgb <= vec3(0.04045));
}

fn encode(light: vec3<f32>) -> vec3<f32> {
    return select(1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055, 12.92 * light, light <= vec3(0.0031308));
}

// egui's textures hold encoded colours.
@fragment
fn widget(in: Corner) -> @location(0) vec4<f32> {
    let colour = in.colour * textureSample(image, nearby, in.at);
    return vec4(select(linear(colour.rgb), colour.rgb, globals.encoded > 0.5), colour.a);
}

// The scene's picture is sampled as linear light.
@fragment
fn picture(in: Corner) -> @location(0) vec4<f32> {
    let light = textureSample(image, nearby, in.at).rgb;
    return vec4(select(light, encode(light), globals.encoded > 0.5), 1.0);
}
