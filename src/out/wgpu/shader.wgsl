// Placed, coloured triangles and wide lines to light: a head light, a key light over the left shoulder and a sky.
// Depth is reversed: 1 at the near plane, 0 at infinity.

struct Globals {
    clip: mat4x4<f32>,           // scene-centred world to clip
    eye: vec4<f32>,              // scene-centred
    key: vec4<f32>,              // unit, towards the key light
    top: vec4<f32>,              // background, linear
    bottom: vec4<f32>,
    size: vec2<f32>,             // pixels
    near: f32,
    backfaces: f32,              // 1: paint them
};

@group(0) @binding(0) var<uniform> globals: Globals;

struct Surface {
    @builtin(position) clip: vec4<f32>,
    @location(0) place: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) colour: vec3<f32>,
};

fn linear(srgb: vec3<f32>) -> vec3<f32> {
    return select(pow((srgb + 0.055) / 1.055, vec3(2.4)), srgb / 12.92, srgb <= vec3(0.04045));
}

@vertex
fn surface_vertex(
    @location(0) place: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) colour: vec4<f32>,
) -> Surface {
    return Surface(globals.clip * vec4(place, 1.0), place, normal, linear(colour.rgb));
}

@fragment
fn surface_fragment(in: Surface, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let to_eye = normalize(globals.eye.xyz - in.place);
    var normal = normalize(in.normal);
    if dot(normal, to_eye) < 0.0 {
        normal = -normal;
    }
    var colour = in.colour;
    if !front && globals.backfaces > 0.5 {
        colour = vec3(0.9, 0.0, 0.6);
    }
    let facing = max(dot(normal, to_eye), 0.0);
    let key = max(dot(normal, globals.key.xyz), 0.0);
    let sky = mix(vec3(0.18, 0.18, 0.20), vec3(0.34, 0.35, 0.37), 0.5 + 0.5 * normal.z);
    let diffuse = sky + 0.33 * facing + 0.54 * key;
    let halfway = normalize(to_eye + globals.key.xyz);
    let gloss = 0.12 * pow(max(dot(normal, halfway), 0.0), 40.0);
    let rim = 0.06 * pow(1.0 - facing, 4.0);
    return vec4(colour * diffuse + gloss + rim, 1.0);
}

struct Line {
    @builtin(position) clip: vec4<f32>,
    @location(0) colour: vec4<f32>,
};

// Lines lie on the surface they belong to: they are drawn as if this much nearer to the eye.
const NEARER: f32 = 1.0008;

// Six vertices per segment: two triangles of a strip of constant width on the screen, with square caps.
@vertex
fn line_vertex(
    @builtin(vertex_index) corner: u32,
    @location(0) first: vec3<f32>,
    @location(1) last: vec3<f32>,
    @location(2) colour: vec4<f32>,
    @location(3) width: f32,
) -> Line {
    var a = globals.clip * vec4(first, 1.0);
    var b = globals.clip * vec4(last, 1.0);
    if max(a.w, b.w) < globals.near {
        return Line(vec4(0.0, 0.0, 2.0, 1.0), vec4(0.0)); // behind the eye: outside the clip volume
    }
    let whole_a = a;
    if a.w < globals.near {
        a = mix(a, b, (globals.near - a.w) / (b.w - a.w));
    }
    if b.w < globals.near {
        b = mix(whole_a, b, (globals.near - whole_a.w) / (b.w - whole_a.w));
    }
    let half_size = 0.5 * globals.size;
    let pixel_a = a.xy / a.w * half_size;
    let pixel_b = b.xy / b.w * half_size;
    var along = pixel_b - pixel_a;
    // Translucent lines fade out where they would cover the shading they lie on.
    let opacity = select(colour.a * smoothstep(1.0, 6.0, length(along)), 1.0, colour.a == 1.0);
    along = select(vec2(1.0, 0.0), normalize(along), dot(along, along) > 1e-12);
    let across = vec2(-along.y, along.x);
    let at_end = corner == 1u || corner == 2u || corner == 4u;
    let at_left = corner == 2u || corner == 4u || corner == 5u;
    let offset = 0.5 * width * (select(-along, along, at_end) + select(-across, across, at_left));
    var clip = select(a, b, at_end);
    clip = vec4(clip.xy + offset / half_size * clip.w, clip.z * NEARER, clip.w);
    return Line(clip, vec4(linear(colour.rgb), opacity));
}

@fragment
fn line_fragment(in: Line) -> @location(0) vec4<f32> {
    return in.colour;
}

struct Backdrop {
    @builtin(position) clip: vec4<f32>,
    @location(0) height: f32,
};

// One triangle that covers the picture.
@vertex
fn backdrop_vertex(@builtin(vertex_index) corner: u32) -> Backdrop {
    let place = vec2(f32(corner & 1u) * 4.0 - 1.0, f32(corner >> 1u) * 4.0 - 1.0);
    return Backdrop(vec4(place, 0.0, 1.0), 0.5 + 0.5 * place.y);
}

@fragment
fn backdrop_fragment(in: Backdrop) -> @location(0) vec4<f32> {
    return vec4(mix(globals.bottom.rgb, globals.top.rgb, in.height), 1.0);
}
