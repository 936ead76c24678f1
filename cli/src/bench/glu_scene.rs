//! The Utah teapot with three holes in each of its 32 patches -> triangles, error in pixels, cracks and single-thread
//! time from four sides for several tolerances, or frame times along 300 views of that path.
//!
//! Also measures the triangles of another program for the same scene, and prints the scene's control points for it
//! (docs/benchmarks.md: libGLU).

use super::flight::ms;
use super::uploads::Uploads;
use crate::input::read_at_most;
use crate::limits::unprepared;
use crate::tessellate::positive;
use crate::{Common, Done, Failure};
use cpu_time::ThreadTime;
use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};
use trimtess::control::{Alone, Control};
use trimtess::frame::internals::{Scratch, tessellate_tile};
use trimtess::frame::{Plan, PlanLimits, plan_for_view_on};
use trimtess::glam::{DVec2, DVec3};
use trimtess::mesh::{MeshLists, NormalFormat, VertexLayout};
use trimtess::model::{FreeTrims, Model, NurbsSurface, PartBuilder, ShellKind, Surface, TrimCurve, TrimRule};
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::{Prepared, prepare, prepare_on};
use trimtess::view::{Camera, Projection, View};

const SIZE: (u32, u32) = (1920, 1080);
/// What the other program stores: position, normal and (u,v), 32 bytes.
const LAYOUT: VertexLayout = VertexLayout::COMPACT.with_normal(NormalFormat::F32).with_uv(true);
/// Millimetres per unit of the published teapot. The camera path is defined in these units.
const UNIT: f64 = 20.0;
const VIEWS: usize = 4;
/// Maximum length of a file of triangles, bytes: four million of them.
const MOST_BYTES: u64 = 256 << 20;

/// Measure the trimmed teapot of the comparison with libGLU: triangles, error in pixels, cracks, time of one thread.
#[derive(clap::Args)]
#[command(args_conflicts_with_subcommands = true, disable_help_subcommand = true)]
pub(super) struct GluSceneArgs {
    #[command(subcommand)]
    other: Option<Other>,
    /// Tolerances in pixels; prints one line for each.
    #[arg(value_name = "PIXELS", value_parser = positive,
          default_values_t = [4.0, 2.0, 1.4, 1.0, 0.7, 0.5, 0.35, 0.25, 0.1])]
    pixels: Vec<f64>,
}

/// Output other than the table.
#[derive(clap::Subcommand)]
enum Other {
    /// Time frames along 300 views of the path, each rebuilt from scratch or updated from the one before.
    Path {
        /// Tolerances in pixels.
        #[arg(value_name = "PIXELS", value_parser = positive, required = true)]
        pixels: Vec<f64>,
    },
    /// Measure the triangles of another program.
    Triangles {
        /// One file per view, with 16 little-endian f32 per triangle: the patch, then x y z u v of each corner.
        #[arg(value_name = "FILES", required = true)]
        files: Vec<PathBuf>,
    },
    /// Print the control points of the scene in millimetres: numbers of points and patches; the points; 16 indices of
    /// points per patch, u-major.
    Points,
}

impl GluSceneArgs {
    pub(super) fn inputs(&self) -> Vec<&Path> {
        match &self.other {
            Some(Other::Triangles { files }) => files.iter().map(PathBuf::as_path).collect(),
            _ => Vec::new(),
        }
    }
}

pub(super) fn run(args: &GluSceneArgs, common: &Common) -> Result<Done, Failure> {
    let (model, patches) = scene()?;
    match &args.other {
        None => table(model, &patches, &args.pixels, common)?,
        Some(Other::Path { pixels }) => {
            let prepared = Arc::new(prepare(model, &common.prepare()).map_err(unprepared)?);
            pixels.iter().try_for_each(|&px| path(&prepared, px))?;
        }
        Some(Other::Triangles { files }) => {
            let mut judged = TriangleQuality::default();
            for (k, file) in files.iter().enumerate() {
                let read = read_at_most(file, MOST_BYTES);
                let bytes = read.map_err(|e| Failure::Cannot(format!("{}: {e}", file.display())))?;
                judged.add(&read_triangles(&bytes, patches.len())?, &patches, &PathCamera::of_view(k));
            }
            crate::tell(&format!("{}\n", judged.row()))?;
        }
        Some(Other::Points) => crate::tell(&points(&patches))?,
    }
    Ok(Done::Clean)
}

/// The teapot with two circles and a flower of 48 straight segments cut out of each patch, and its patches.
fn scene() -> Result<(Model, Vec<NurbsSurface>), Failure> {
    let teapot = trimtess_models::by_name("teapot").ok_or_else(|| Failure::cannot("no teapot"))?;
    let flower = |k: u32| {
        let angle = TAU * f64::from(k) / 48.0;
        DVec2::new(0.5, 0.7) + DVec2::from_angle(angle) * 0.22 * (0.75 + 0.25 * (5.0 * angle).cos())
    };
    let holes = [
        TrimCurve::circle(DVec2::new(0.25, 0.25), 0.15),
        TrimCurve::circle(DVec2::new(0.75, 0.25), 0.15),
        TrimCurve::polygon((0..48).map(flower).collect()),
    ];
    let trims = FreeTrims { rule: TrimRule::Handedness, curves: holes.iter().map(TrimCurve::reversed).collect() };
    let mut part = PartBuilder::new("trimmed teapot");
    let shell = part.plain_shell(ShellKind::Open);
    let mut patches = Vec::new();
    for face in &teapot.parts[0].faces {
        let Surface::Nurbs(patch) = &face.surface else { return Err(Failure::cannot("the teapot is NURBS")) };
        part.trimmed_face(face.surface.clone(), shell, trims.clone(), face.reversed);
        patches.push(patch.clone());
    }
    Ok((part.finish().map_err(Failure::cannot)?.into(), patches))
}

fn table(model: Model, patches: &[NurbsSurface], tolerances: &[f64], common: &Common) -> Result<(), Failure> {
    let start = Instant::now();
    let prepared = prepare_on(&Alone, &model, &common.prepare(), &Control::default()).map_err(unprepared)?;
    let (spent, tiles) = (ms(start.elapsed()), prepared.tiles().count());
    crate::tell(&format!(
        "prepared in {spent:.1} ms; {tiles} tiles\n    px | {}| plan ms | tiles ms | Mtri/s\n",
        TriangleQuality::HEAD
    ))?;
    for &px in tolerances {
        let mut judged = TriangleQuality::default();
        let (mut planning, mut making) = (Duration::ZERO, Duration::ZERO);
        for k in 0..VIEWS {
            let camera = PathCamera::of_view(k);
            let (plan, [p, t]) = timed(&prepared, &camera.view(px));
            planning += p;
            making += t;
            judged.add(&triangles(&prepared, &plan), patches, &camera);
        }
        let [planning, making] = [planning, making].map(|t| ms(t) / VIEWS as f64);
        let rate = judged.count as f64 / VIEWS as f64 / (planning + making) * 1e-3;
        crate::tell(&format!("{px:6.2} | {}| {planning:7.3} | {making:8.3} | {rate:6.2}\n", judged.row()))?;
    }
    Ok(())
}

/// Makes a plan, and times planning and tessellating: minimum of some rounds, each long enough for the clock.
fn timed(prepared: &Prepared, view: &View) -> (Plan, [Duration; 2]) {
    const ROUNDS: u32 = 5;
    const TIMES: u32 = 10;
    let mut scratch = Scratch::default();
    let control = Control::default();
    let plan = || plan_for_view_on(&Alone, prepared, view, &PlanLimits::DEFAULT, &control).unwrap_or_default();
    let made = plan();
    let mut least = [Duration::MAX; 2];
    for _ in 0..ROUNDS {
        let begun = time();
        for _ in 0..TIMES {
            std::hint::black_box(plan());
        }
        let planned = time();
        for (part, tile, _) in (0..TIMES).flat_map(|_| prepared.tiles()) {
            let outcome = tessellate_tile(prepared, &made, (part, tile), MeshLists::NONE, &mut scratch);
            scratch.reuse(std::hint::black_box(outcome).mesh);
        }
        least = [least[0].min((planned - begun) / TIMES), least[1].min((time() - planned) / TIMES)];
    }
    (made, least)
}

/// Flies the path on this thread alone and prints its processor time per frame.
fn path(prepared: &Arc<Prepared>, px: f64) -> Result<(), Failure> {
    const FRAMES: usize = 300;
    const ROUNDS: usize = 5;
    let options = SessionOptions::DEFAULT.with_workers(1).with_edge_lines(false);
    for coherent in [false, true] {
        let mut least = Duration::MAX;
        let (mut triangles, mut tiles) = (0_u64, 0_u64);
        for _ in 0..ROUNDS {
            let mut session = Session::start_on(Arc::new(Alone), Arc::clone(prepared), &options);
            let mut sink = Uploads::written_by(&mut session, LAYOUT);
            let mut took = Duration::ZERO;
            (triangles, tiles) = (0, 0);
            for k in 0..FRAMES {
                let view = PathCamera::on_path(k, FRAMES).view(px);
                sink.next_frame();
                let begun = time();
                let report = if coherent {
                    session.view(&[view], &mut sink)
                } else {
                    session.frame(session.plan_for_view(&view, &PlanLimits::DEFAULT), &mut sink)
                };
                let report = report.map_err(Failure::cannot)?;
                took += time() - begun;
                tiles += report.tiles as u64;
                triangles += sink.held().triangles;
            }
            least = least.min(took);
        }
        let ms = ms(least) / FRAMES as f64;
        let [triangles, tiles] = [triangles, tiles].map(|n| n as f64 / FRAMES as f64);
        let how = if coherent { "coherent" } else { "rebuilt " };
        let rate = 1e3 / ms;
        crate::tell(&format!(
            "{px:6.2} px, {how} | {ms:7.3} ms/frame, {rate:8.1} frames/s | {triangles:7.0} triangles, \
             {tiles:5.1} tiles made\n"
        ))?;
    }
    Ok(())
}

/// Processor time of this thread.
fn time() -> Duration {
    ThreadTime::now().as_duration()
}

/// A corner of a triangle.
#[derive(Clone, Copy)]
struct Corner {
    point: DVec3,
    uv: DVec2,
}

struct Triangle {
    patch: usize,
    corners: [Corner; 3],
}

fn triangles(prepared: &Prepared, plan: &Plan) -> Vec<Triangle> {
    let mut scratch = Scratch::default();
    let mut out = Vec::new();
    for (part, tile, _) in prepared.tiles() {
        let outcome = tessellate_tile(prepared, plan, (part, tile), MeshLists::ALL, &mut scratch);
        let mesh = &outcome.mesh;
        let corner = |v: u32| Corner { point: mesh.positions[v as usize], uv: mesh.uvs[v as usize].as_dvec2() };
        let patch = outcome.face.index();
        out.extend(mesh.triangles.iter().map(|t| Triangle { patch, corners: t.map(corner) }));
    }
    out
}

fn read_triangles(bytes: &[u8], patches: usize) -> Result<Vec<Triangle>, Failure> {
    if bytes.is_empty() || !bytes.len().is_multiple_of(64) {
        return Err(Failure::cannot(format!("{} bytes are not triangles of 64 bytes each", bytes.len())));
    }
    let numbers: Vec<f64> = bytes.as_chunks().0.iter().map(|b| f64::from(f32::from_le_bytes(*b))).collect();
    let corner = |x: &[f64]| Corner { point: DVec3::new(x[0], x[1], x[2]), uv: DVec2::new(x[3], x[4]) };
    let triangle = |x: &[f64; 16]| Triangle {
        patch: x[0] as usize,
        corners: [corner(&x[1..6]), corner(&x[6..11]), corner(&x[11..16])],
    };
    let triangles: Vec<Triangle> = numbers.as_chunks().0.iter().map(triangle).collect();
    let is_patch = |x: f64| x >= 0.0 && x < patches as f64 && x.fract() == 0.0;
    match numbers.iter().step_by(16).find(|x| !is_patch(**x)) {
        Some(wrong) => Err(Failure::cannot(format!("a triangle belongs to patch {wrong} of only {patches}"))),
        None => Ok(triangles),
    }
}

/// Control points of the scene, and indices of them for each patch.
fn points(patches: &[NurbsSurface]) -> String {
    let mut text = format!("{} {}\n", 16 * patches.len(), patches.len());
    for p in patches.iter().flat_map(|patch| &patch.points) {
        text += &format!("{} {} {}\n", p.x, p.y, p.z);
    }
    for k in 0..patches.len() {
        let numbers: Vec<String> = (0..16).map(|i| (16 * k + i).to_string()).collect();
        text += &format!("{}\n", numbers.join(" "));
    }
    text
}

/// A camera on the path around the teapot.
struct PathCamera(Camera);

impl PathCamera {
    const FOV_Y: f64 = FRAC_PI_4;
    const NEAR: f64 = 0.5 * UNIT;

    fn of_view(k: usize) -> Self {
        Self::on_path(k, VIEWS)
    }

    fn on_path(k: usize, frames: usize) -> Self {
        let a = TAU * k as f64 / frames as f64;
        let (height, distance) = (0.35 + 0.15 * (2.0 * a).sin(), 8.0 + 3.0 * a.cos());
        let back = DVec3::new(a.cos() * height.cos(), a.sin() * height.cos(), height.sin());
        let eye = (DVec3::Z * 1.2 + back * distance) * UNIT;
        let right = (-back).cross(DVec3::Z).normalize();
        let projection = Projection::Perspective { fov_y: Self::FOV_Y, near: Self::NEAR };
        Self(Camera { eye, forward: -back, up: right.cross(-back), projection })
    }

    fn view(&self, px: f64) -> View {
        View { camera: self.0, size: SIZE, deviation_px: px, size_px: None, angle: FRAC_PI_2 }
    }

    /// Projects a point to pixels from the middle of the picture.
    fn project(&self, point: DVec3) -> DVec2 {
        let Camera { eye, forward, up, .. } = self.0;
        let local = point - eye;
        let focal = 0.5 * f64::from(SIZE.1) / (0.5 * Self::FOV_Y).tan();
        DVec2::new(forward.cross(up).dot(local), up.dot(local)) * focal / forward.dot(local)
    }
}

/// Quality measures of triangles.
#[derive(Default)]
struct TriangleQuality {
    views: usize,
    count: usize,
    /// Screen-space distances between samples of triangles and the nearest points of the surface.
    pixels: Vec<f64>,
    /// Triangle edges along borders shared by two patches, and how many of them have no partner.
    border_edges: usize,
    unmatched: usize,
}

impl TriangleQuality {
    const HEAD: &str = "triangles / view | px max,  99 %, median | T-junctions ";

    fn add(&mut self, triangles: &[Triangle], patches: &[NurbsSurface], camera: &PathCamera) {
        self.views += 1;
        self.count += triangles.len();
        let shared = shared_sides(patches);
        let key = |c: &Corner| c.point.to_array().map(|x| (x + 0.0).to_bits());
        let mut edges: HashMap<[[u64; 3]; 2], (usize, bool)> = HashMap::new();
        for Triangle { patch, corners } in triangles {
            let pixels = places().map(|w| deviation(&patches[*patch], corners, w, camera));
            self.pixels.extend(pixels);
            for k in 0..3 {
                let ends = [corners[k], corners[(k + 1) % 3]];
                let [a, b] = ends.each_ref().map(key);
                let edge = edges.entry(if a < b { [a, b] } else { [b, a] }).or_default();
                edge.0 += 1;
                edge.1 |= side(ends).is_some_and(|side| shared[*patch][side]);
            }
        }
        let on_border = || edges.values().filter(|edge| edge.1);
        self.border_edges += on_border().count();
        self.unmatched += on_border().filter(|edge| edge.0 % 2 == 1).count();
    }

    fn row(&mut self) -> String {
        self.pixels.sort_by(f64::total_cmp);
        let share = |share: f64| self.pixels[(share * (self.pixels.len() - 1) as f64) as usize];
        let [max, most, median] = [share(1.0), share(0.99), share(0.5)];
        let t = 100.0 * self.unmatched as f64 / self.border_edges.max(1) as f64;
        let count = self.count as f64 / self.views.max(1) as f64;
        format!("{count:16.0} | {max:6.3} {most:6.3} {median:7.4} | {:5} {t:4.0} % ", self.unmatched)
    }
}

/// Barycentric coordinates of the samples of a triangle: a grid of fifths without the corners.
fn places() -> impl Iterator<Item = DVec3> {
    const N: u32 = 5;
    let all = (0..=N).flat_map(|i| (0..=N - i).map(move |j| [i, j, N - i - j]));
    all.filter(|w| !w.contains(&N)).map(|w| DVec3::from(w.map(f64::from)) / f64::from(N))
}

/// Screen-space distance of a triangle's sample to the nearest point of the surface.
fn deviation(patch: &NurbsSurface, corners: &[Corner; 3], w: DVec3, camera: &PathCamera) -> f64 {
    let [a, b, c] = corners;
    let point = a.point * w.x + b.point * w.y + c.point * w.z;
    let mut uv = a.uv * w.x + b.uv * w.y + c.uv * w.z;
    let mut next = patch.point(uv.x, uv.y);
    // Gauss-Newton.
    for _ in 0..8 {
        let d = patch.derivatives(uv.x, uv.y);
        if point.distance_squared(d.point) <= point.distance_squared(next) {
            next = d.point;
        }
        let (off, [g, h, k]) = (point - d.point, [d.du.dot(d.du), d.du.dot(d.dv), d.dv.dot(d.dv)]);
        let (x, y, det) = (off.dot(d.du), off.dot(d.dv), g * k - h * h);
        if det <= 1e-14 * (g + k) * (g + k) {
            break;
        }
        uv = (uv + DVec2::new(k * x - h * y, g * y - h * x) / det).clamp(DVec2::ZERO, DVec2::ONE);
    }
    camera.project(point).distance(camera.project(next))
}

/// The side of the patch (u = 0, u = 1, v = 0, v = 1) that a triangle edge lies on.
fn side(ends: [Corner; 2]) -> Option<usize> {
    let on = |at: fn(&Corner) -> f64| ends.iter().all(|c| at(c).abs() < 1e-5);
    [on(|c| c.uv.x), on(|c| 1.0 - c.uv.x), on(|c| c.uv.y), on(|c| 1.0 - c.uv.y)].iter().position(|&on| on)
}

/// Which sides of each patch are shared with another patch.
fn shared_sides(patches: &[NurbsSurface]) -> Vec<[bool; 4]> {
    let key = |p: &DVec3| p.to_array().map(|x| (x + 0.0).to_bits());
    let of_patch = |patch: &NurbsSurface| {
        let side = |at: fn(usize) -> usize| {
            let points = [0, 1, 2, 3].map(|i| key(&patch.points[at(i)]));
            let [a, b, c, d] = points;
            points.min([d, c, b, a])
        };
        [side(|i| i), side(|i| 12 + i), side(|i| 4 * i), side(|i| 4 * i + 3)]
    };
    let sides: Vec<[[[u64; 3]; 4]; 4]> = patches.iter().map(of_patch).collect();
    let shared = |side: &[[u64; 3]; 4]| sides.iter().flatten().filter(|other| *other == side).count() > 1;
    sides.iter().map(|of| of.each_ref().map(shared)).collect()
}
