// The example's own shaders, after the text that the scene gives. Bind group 0 is the scene's.

struct Light {
    clip: mat4x4<f32>,           // world relative to the eye, to the shadow map's clip space
    towards: vec4<f32>,          // unit; w is a texel of the shadow map, millimetres
    floor: vec4<f32>,            // its middle, relative to the eye; w is the radius at which it ends
};

@group(1) @binding(0) var<uniform> light: Light;
@group(2) @binding(0) var shadows: texture_depth_2d;
@group(2) @binding(1) var comparing: sampler_comparison;

const SUN: vec3<f32> = vec3(2.7, 2.55, 2.35);
const BACKGROUND: vec3<f32> = vec3(0.780, 0.800, 0.826); // as the pass is cleared

// At the centroid of what is covered: beyond the rim of a surface normals would turn away.
struct Fragment {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(perspective, centroid) position: vec3<f32>,
    @location(1) @interpolate(perspective, centroid) normal: vec3<f32>,
    @location(2) colour: vec3<f32>,
};

// Depth alone: a pipeline without fragments.
@vertex
fn model_shadow(in: SceneVertex) -> @builtin(position) vec4<f32> {
    return scene_surface(in).clip;
}

@vertex
fn model(in: SceneVertex) -> Fragment {
    let it = scene_surface(in);
    return Fragment(it.clip, it.position, it.normal, it.colour);
}

// The floor and the box: positions are relative to the camera's eye.
@vertex
fn other_shadow(@location(0) position: vec3<f32>) -> @builtin(position) vec4<f32> {
    return light.clip * vec4(position, 1.0);
}

@vertex
fn other(@location(0) position: vec3<f32>, @location(1) normal: vec3<f32>, @location(2) colour: vec3<f32>) -> Fragment {
    return Fragment(scene_view.clip * vec4(position, 1.0), position, normal, colour);
}

// The part of the sun that arrives: the mean of 49 comparisons, each of four texels.
fn lit(position: vec3<f32>, normal: vec3<f32>) -> f32 {
    // Off the surface by more than the texels that are compared cover, or it would shade itself.
    let slope = 1.0 - max(dot(normal, light.towards.xyz), 0.0);
    let off = position + normal * light.towards.w * (1.5 + 5.0 * slope);
    let clip = light.clip * vec4(off, 1.0);
    let at = vec2(0.5, -0.5) * clip.xy / clip.w + 0.5;
    let texel = 1.0 / vec2<f32>(textureDimensions(shadows));
    var sum = 0.0;
    for (var y = -3; y <= 3; y++) {
        for (var x = -3; x <= 3; x++) {
            let tap = at + vec2(f32(x), f32(y)) * texel;
            sum += textureSampleCompareLevel(shadows, comparing, tap, clip.z / clip.w);
        }
    }
    return sum / 49.0;
}

// A studio: a dark floor, walls, a bright ceiling, and a lamp where the sun is. Blurred as a rough surface sees it.
fn surroundings(direction: vec3<f32>, roughness: f32) -> vec3<f32> {
    let blur = 0.08 + 0.8 * roughness;
    let floor_to_wall = mix(vec3(0.12, 0.11, 0.11), vec3(0.34, 0.37, 0.42), smoothstep(-blur, blur, direction.z));
    let with_ceiling = mix(floor_to_wall, vec3(0.95, 0.98, 1.03), smoothstep(0.55 - blur, 0.75 + blur, direction.z));
    let lamp = smoothstep(0.86 - 0.5 * blur, 0.96, dot(direction, light.towards.xyz));
    return with_ceiling + 1.2 * lamp * (1.0 - roughness);
}

// Cook and Torrance's reflection with GGX facets, lit by the sun and the studio.
fn shaded(in: Fragment, roughness: f32, metal: f32) -> vec3<f32> {
    let to_eye = scene_to_eye(in.position);
    var normal = normalize(in.normal);
    normal = select(-normal, normal, dot(normal, to_eye) >= 0.0);
    let n_v = max(dot(normal, to_eye), 1e-3);
    let n_l = dot(normal, light.towards.xyz);
    let halfway = normalize(to_eye + light.towards.xyz);
    let n_h = max(dot(normal, halfway), 0.0);
    let a2 = pow(roughness, 4.0);
    let facets = a2 / (3.14159 * pow(n_h * n_h * (a2 - 1.0) + 1.0, 2.0));
    let k = 0.125 * (roughness + 1.0) * (roughness + 1.0);
    let masked = 0.25 / ((n_v * (1.0 - k) + k) * (max(n_l, 0.0) * (1.0 - k) + k));
    let at_normal = mix(vec3(0.04), in.colour, metal);
    let fresnel = at_normal + (1.0 - at_normal) * pow(1.0 - saturate(dot(to_eye, halfway)), 5.0);
    let diffuse = in.colour * (1.0 - metal);
    let sun = SUN * max(n_l, 0.0) * select(0.0, lit(in.position, normal), n_l > 0.0);
    // Reflections at grazing angles (Schlick), less so on rough surfaces.
    let rim = at_normal + (max(vec3(1.0 - roughness), at_normal) - at_normal) * pow(saturate(1.0 - n_v), 5.0);
    let mirrored = surroundings(reflect(-to_eye, normal), roughness);
    return sun * (diffuse / 3.14159 + fresnel * facets * masked)
        + 0.6 * diffuse * surroundings(normal, 1.0) + rim * mirrored;
}

// Linear light to the target, which stores what it is given. Alpha tells what the pixel shows.
fn stored(colour: vec3<f32>, what: f32) -> vec4<f32> {
    // Narkowicz's fit of a film's response.
    let film = saturate(colour * (2.51 * colour + 0.03) / (colour * (2.43 * colour + 0.59) + 0.14));
    return vec4(select(1.055 * pow(film, vec3(1.0 / 2.4)) - 0.055, 12.92 * film, film <= vec3(0.0031308)), what);
}

@fragment
fn model_fragment(in: Fragment) -> @location(0) vec4<f32> {
    return stored(shaded(in, 0.38, 0.7), 1.0);
}

@fragment
fn other_fragment(in: Fragment) -> @location(0) vec4<f32> {
    // The floor is grey, and ends in the background.
    let is_floor = in.colour.r == in.colour.b;
    let far = smoothstep(0.25, 1.0, distance(in.position.xy, light.floor.xy) / light.floor.w);
    let colour = stored(shaded(in, select(0.5, 0.85, is_floor), 0.0), select(0.4, 0.2, is_floor));
    return vec4(mix(colour.rgb, BACKGROUND, select(0.0, far, is_floor)), colour.a);
}
