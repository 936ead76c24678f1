
// Shades tiles and lines with a head light, a key light over the left shoulder and a sky.

struct Style {
    key: vec4<f32>,              // unit, towards the key light
    top: vec4<f32>,              // background, linear
    bottom: vec4<f32>,
    nearer: vec2<f32>,           // depth bias of lines, which lie on surfaces: factor and offset
    backfaces: f32,              // 1: paint back faces magenta
};

@group(0) @binding(1) var<uniform> style: Style;

// Pens: red, green, blue (sRGB) and alpha; pixels. Triangle edges are thin and translucent, so that dense meshes keep
// their shading; both adjacent triangles draw each. Lattice lines and B-rep edges stand out from them.
const WIRE: vec4<f32> = vec4(0.094, 0.118, 0.173, 0.358);
const WIRE_WIDTH: f32 = 1.0;
const LATTICE: vec4<f32> = vec4(0.02, 0.16, 0.42, 0.9);
const LATTICE_WIDTH: f32 = 1.3;
const EDGE: vec4<f32> = vec4(0.063, 0.071, 0.086, 1.0);
const EDGE_WIDTH: f32 = 1.7;

struct Surface {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) colour: vec3<f32>,
    @location(3) @interpolate(flat) mirrored: u32,
    @location(4) @interpolate(flat) tile: u32,
};

@vertex
fn surface_vertex(vertex: SceneVertex) -> Surface {
    let it = scene_surface(vertex);
    return Surface(it.clip, it.position, it.normal, it.colour, u32(it.mirrored), it.tile);
}

@fragment
fn surface_fragment(in: Surface, @builtin(front_facing) counter_clockwise: bool) -> @location(0) vec4<f32> {
    if scene_beyond(in.position) > 0.0 {
        discard;
    }
    let to_eye = scene_to_eye(in.position);
    var normal = normalize(in.normal);
    if dot(normal, to_eye) < 0.0 {
        normal = -normal;
    }
    var colour = in.colour;
    let is_back = counter_clockwise == (in.mirrored == 1u);
    if is_back && style.backfaces > 0.5 {
        colour = vec3(0.9, 0.0, 0.6);
    } else if is_back && any(scene_view.section.xyz != vec3(0.0)) {
        // The inside of a solid, flat: as if it were the cut.
        return vec4(0.45 * colour, 1.0);
    }
    let facing = max(dot(normal, to_eye), 0.0);
    let key = max(dot(normal, style.key.xyz), 0.0);
    let sky = mix(vec3(0.18, 0.18, 0.20), vec3(0.34, 0.35, 0.37), 0.5 + 0.5 * normal.z);
    let diffuse = sky + 0.33 * facing + 0.54 * key;
    let halfway = normalize(to_eye + style.key.xyz);
    let gloss = 0.12 * pow(max(dot(normal, halfway), 0.0), 40.0);
    let rim = 0.06 * pow(saturate(1.0 - facing), 4.0);
    return vec4(colour * diffuse + gloss + rim, 1.0);
}

struct Ruled {
    @builtin(position) clip: vec4<f32>,
    @location(0) cell: vec2<f32>,
    @location(1) beyond: f32,
};

fn ruled(place: ScenePlace, position: vec3<f32>, cell: vec2<f32>) -> Ruled {
    let world = scene_placed(place, position);
    var clip = scene_view.clip * vec4(world, 1.0);
    clip.z = clip.z * style.nearer.x + style.nearer.y;
    return Ruled(clip, cell, scene_beyond(world));
}

// Covers pixels less than half a line width from a whole number of cells.
@fragment
fn lattice_fragment(in: Ruled) -> @location(0) vec4<f32> {
    let per_pixel = fwidth(in.cell);
    let off = abs(in.cell - round(in.cell)) / max(per_pixel, vec2(1e-6));
    let lines = 1.0 - smoothstep(vec2(0.0), vec2(1.0), off - 0.5 * vec2(LATTICE_WIDTH - 1.0));
    // Fade out lines a few pixels apart, which would cover the surface. Constant coordinates have no lines.
    let seen = (1.0 - smoothstep(vec2(0.15), vec2(0.5), per_pixel)) * step(vec2(1e-6), per_pixel);
    let opacity = max(lines.x * seen.x, lines.y * seen.y) * LATTICE.a;
    if in.beyond > 0.0 {
        discard;
    }
    return vec4(scene_linear(LATTICE.rgb), opacity);
}

// Picks: the number of the tile plus one, and the distance from the eye, in orthographic projection from its plane.
@fragment
fn pick_fragment(in: Surface) -> @location(0) vec4<u32> {
    if scene_beyond(in.position) > 0.0 {
        discard;
    }
    let far = select(length(in.position), -dot(in.position, scene_view.eye.xyz), scene_view.eye.w > 0.5);
    return vec4(in.tile + 1u, bitcast<u32>(far), 0u, 0u);
}

struct Line {
    @builtin(position) clip: vec4<f32>,
    @location(0) colour: vec4<f32>,
    @location(1) beyond: f32,
};

// Outside the clip volume.
fn no_line() -> Line {
    return Line(vec4(0.0, 0.0, 2.0, 1.0), vec4(0.0), 1.0);
}

// One of the six vertices of a segment, drawn as two triangles of constant width on the screen with square caps.
fn strip(first: vec3<f32>, last: vec3<f32>, corner: u32, colour: vec4<f32>, width: f32) -> Line {
    var a = scene_view.clip * vec4(first, 1.0);
    var b = scene_view.clip * vec4(last, 1.0);
    if max(a.w, b.w) < scene_view.near {
        return no_line(); // behind the eye
    }
    let whole_a = a;
    var beyond = vec2(scene_beyond(first), scene_beyond(last));
    let whole_beyond = beyond;
    if a.w < scene_view.near {
        let cut = (scene_view.near - a.w) / (b.w - a.w);
        a = mix(a, b, cut);
        beyond.x = mix(whole_beyond.x, whole_beyond.y, cut);
    }
    if b.w < scene_view.near {
        let cut = (scene_view.near - whole_a.w) / (b.w - whole_a.w);
        b = mix(whole_a, b, cut);
        beyond.y = mix(whole_beyond.x, whole_beyond.y, cut);
    }
    let half_size = 0.5 * scene_view.size;
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
    clip = vec4(clip.xy + offset / half_size * clip.w, clip.z * style.nearer.x + style.nearer.y, clip.w);
    return Line(clip, vec4(scene_linear(colour.rgb), opacity), select(beyond.x, beyond.y, at_end));
}

// Points of polylines, one after the other; w is 0 in the last point of each.
@group(1) @binding(0) var points: texture_2d<f32>;

// Six vertices per point. The instance index is the place.
@vertex
fn edge_vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Line {
    let place = scene_place(instance);
    let first = textureLoad(points, scene_texel(vertex / 6u), 0);
    let last = textureLoad(points, scene_texel(vertex / 6u + 1u), 0);
    if first.w == 0.0 {
        return no_line();
    }
    return strip(
        scene_placed(place, first.xyz), scene_placed(place, last.xyz), vertex % 6u, EDGE, EDGE_WIDTH);
}

@fragment
fn line_fragment(in: Line) -> @location(0) vec4<f32> {
    if in.beyond > 0.0 {
        discard;
    }
    return in.colour;
}

struct Backdrop {
    @builtin(position) clip: vec4<f32>,
    @location(0) height: f32,
};

// One triangle that covers the whole picture.
@vertex
fn backdrop_vertex(@builtin(vertex_index) corner: u32) -> Backdrop {
    let place = vec2(f32(corner & 1u) * 4.0 - 1.0, f32(corner >> 1u) * 4.0 - 1.0);
    return Backdrop(vec4(place, 0.0, 1.0), 0.5 + 0.5 * place.y);
}

@fragment
fn backdrop_fragment(in: Backdrop) -> @location(0) vec4<f32> {
    return vec4(mix(style.bottom.rgb, style.top.rgb, in.height), 1.0);
}
