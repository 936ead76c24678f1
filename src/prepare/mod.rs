//! Paid once per model: Bézier patches, pcurves, tiles, shared edges, bounds. Parallel over faces (rayon).

mod arc_bounds;

mod arcs;

mod arrangement;

mod boxes;

mod bounds;
pub use bounds::{Bend, BoundingBox, BoxBounds, CurveBounds, StripBounds, SurfaceBounds};

mod box_tree;

mod carry;

mod critical;

mod cuts;

/// NURBS to Bézier pieces.
pub mod decompose;
pub use decompose::{BezierPatches, BezierSpline3};

mod draft;

mod extent;

mod face;

mod face_error;
use face_error::FaceError;

mod free_edges;

mod free_region;
pub use free_region::{FreeRegion, NoRegion, TrimNote};

mod heal;

mod images;
pub use images::EdgeImages;
pub(crate) use images::Image;

mod inside;

mod intersect;
pub use intersect::{CurveMeeting, CurvePlace, MeetingKind, intersections};

mod lead;

mod lobes;

mod limits;
pub use limits::{PrepareError, PrepareLimits};

mod meeting;

mod nearest;

mod orient;

mod overlap;

mod pairs;

mod pcurve;
mod polygon;

mod prepared;
pub use prepared::{Break, EdgeShape, EdgeUse, OpenEdges, Prepared, PreparedEdge, PreparedFace, PreparedPart, Tile};

mod region;

mod sew;

mod shells;
pub use shells::Shells;

mod spans;
pub use spans::UvDomain;

mod mend;

mod stretches;

mod thin;

mod topology;

mod uv_curve;
pub use uv_curve::{UvCurve, UvSample};

mod uv_loop;

mod weight;
pub(crate) use weight::nanoseconds;

mod windings;

mod wires;

mod wraps;

use crate::mesh::{Scene, SceneInstance, ScenePart};
use crate::model::{Diagnostic, Face, FaceId, Model, Part, PartId, Severity};
use glam::DVec3;
use limits::Budget;
use rayon::prelude::*;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// Knobs of [`prepare`].
#[derive(Clone, Debug, PartialEq)]
pub struct PrepareOptions {
    /// Threads to use; `None` = the rayon pool the caller is in.
    pub threads: Option<usize>,
    /// What the result may cost.
    pub limits: PrepareLimits,
    /// Share of a part's diagonal up to which borders of faces without topology (with free trims, or kept whole) are one edge
    /// with borders beside them, where the part states no [tolerance](Part::tolerance) of its own. 0: they stay apart.
    pub border_tolerance: f64,
}

impl PrepareOptions {
    /// The caller's rayon pool, within [`PrepareLimits::DEFAULT`]; borders within a millionth of the part are one, which coordinates
    /// of seven digits allow.
    pub const DEFAULT: Self = Self { threads: None, limits: PrepareLimits::DEFAULT, border_tolerance: 1e-6 };
}

impl Default for PrepareOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Makes a model ready for tessellation.
///
/// A face that cannot be used becomes a diagnostic in [`Prepared::diagnostics`], and its neighbours are not touched. The
/// result does not depend on the number of threads. Cost: about 20–200 µs per face.
///
/// # Errors
/// Only when the model costs more than [`PrepareOptions::limits`]; the work stops there.
pub fn prepare(model: Model, options: &PrepareOptions) -> Result<Prepared, PrepareError> {
    let pool = options.threads.and_then(|n| rayon::ThreadPoolBuilder::new().num_threads(n).build().ok());
    match pool {
        Some(pool) => pool.install(|| prepare_all(model, options)),
        None => prepare_all(model, options),
    }
}

fn prepare_all(mut model: Model, options: &PrepareOptions) -> Result<Prepared, PrepareError> {
    let budget = Budget::new(options.limits);
    let parts = model.parts.len();
    let (known, unknown): (Vec<_>, Vec<_>) =
        std::mem::take(&mut model.instances).into_iter().partition(|i| i.part.index() < parts);
    model.instances = known;
    model.diagnostics.extend(unknown.into_iter().map(|i| Diagnostic {
        severity: Severity::Error,
        part: None,
        face: None,
        entity: 0,
        place: None,
        reason: format!("instance \"{}\" places part {} of {parts}", i.name, i.part.0),
    }));
    let of_part = |(k, part): (usize, &Part)| prepare_part(PartId::new(k), part, options.border_tolerance, &budget);
    let done: Vec<DonePart> = model.parts.par_iter().enumerate().map(of_part).collect();
    if budget.exceeded() {
        return Err(budget.error(&model));
    }
    let mut diagnostics = std::mem::take(&mut model.diagnostics);
    let mut parts = Vec::with_capacity(done.len());
    let mut without_area = Vec::with_capacity(done.len());
    for part in done {
        parts.push(Arc::new(part.part));
        diagnostics.extend(part.diagnostics);
        without_area.push(part.without_area);
    }
    let clouds: Vec<_> = parts.par_iter().map(|part| extent::cloud(part)).collect();
    let scene = scene(&model, &clouds, without_area);
    let bounds = extent::placed_box(&clouds, &scene.instances);
    let diagonal = bounds.map_or(0.0, |[low, high]| (high - low).length());
    let scales = scene.largest_scales();
    parts.par_iter_mut().zip(scales).for_each(|(part, scale)| {
        let part = Arc::get_mut(part).expect("a part that was just made has one owner");
        weight::weigh(part, diagonal / scale);
    });
    Ok(Prepared { parts, scene, diagnostics, bounds, diagonal })
}

/// What became of one part.
#[derive(Default)]
struct DonePart {
    part: PreparedPart,
    diagnostics: Vec<Diagnostic>,
    without_area: Vec<FaceId>,
}

/// Share of a part's size within which borders are the same.
const ROUNDING: f64 = 1e-9;

fn prepare_part(id: PartId, stated: &Part, border_tolerance: f64, budget: &Budget) -> DonePart {
    let (low, high) = topology::control_box(stated);
    let size = (high - low).length();
    let (trimmed, mut free) = free_edges::free_faces(stated, size);
    let mut healings = Vec::new();
    let healed = heal::heal(&trimmed, size, &mut healings);
    let (sewn, borders) = sew::sew(healed, &mut free, border_tolerance * size, &mut healings);
    let part = &*sewn;
    healings.sort_by_key(|h| h.face);
    let draft = |(k, (f, free)): (usize, (&Face, &Option<_>))| {
        let span = || tracing::trace_span!("draft", part = id.0, face = k, entity = f.entity);
        let work = || span().in_scope(|| guarded(|| face::draft(part, f, free.as_ref(), size)));
        let drafted = (!f.lost && !budget.exceeded()).then(work)?;
        drafted.iter().for_each(|draft| budget.spend(draft));
        Some(drafted)
    };
    let results: Vec<_> = part.faces.par_iter().zip(&free).enumerate().map(draft).collect();
    if budget.exceeded() {
        // Nothing of this will be kept.
        return DonePart::default();
    }
    let mut diagnostics = Vec::new();
    let mut without_area = Vec::new();
    let mut drafts = Vec::with_capacity(results.len());
    let mut healings = healings.into_iter().peekable();
    for (k, result) in results.into_iter().enumerate() {
        // A face that was lost before it came here has its diagnostic.
        let Some(mut result) = result else {
            drafts.push(None);
            continue;
        };
        let mut tell = |severity, place: Option<DVec3>, reason| {
            let (face, entity) = (Some(FaceId::new(k)), part.faces[k].entity);
            let place = place.or_else(|| face::somewhere(part, &part.faces[k]));
            diagnostics.push(Diagnostic { severity, part: Some(id), face, entity, place, reason });
        };
        while let Some(healing) = healings.next_if(|h| h.face == k) {
            match (&mut result, healing.severity) {
                (Ok(draft), Severity::Warning) => draft.repairs.push(healing.told),
                _ => tell(healing.severity, healing.told.place, healing.told.what),
            }
        }
        match &result {
            Ok(draft) => {
                for told in &draft.repairs {
                    tell(Severity::Warning, told.place, told.what.clone());
                }
                if !draft.notes.is_empty() {
                    tell(Severity::Note, None, draft.notes.join("; "));
                }
            }
            Err(e @ (FaceError::NoArea { .. } | FaceError::NothingKept)) => {
                tell(Severity::Note, None, e.to_string());
                without_area.push(FaceId::new(k));
            }
            Err(e) => tell(Severity::Error, e.place(), e.to_string()),
        }
        drafts.push(result.ok());
    }
    let mut turned = Vec::new();
    // Edges of free trims come after the model's own, and what sewing makes of them after those.
    let finely_cut = if trimmed.edges.len() > stated.edges.len() { stated.edges.len() } else { part.edges.len() };
    let prepared = catch_unwind(AssertUnwindSafe(|| topology::assemble(part, finely_cut, drafts, &mut turned)));
    let prepared = prepared.unwrap_or_else(|panic| {
        let reason = FaceError::Internal(panic_message(&*panic)).to_string();
        diagnostics.extend((0..part.faces.len()).map(|k| Diagnostic {
            severity: Severity::Error,
            part: Some(id),
            face: Some(FaceId::new(k)),
            entity: part.faces[k].entity,
            place: face::somewhere(part, &part.faces[k]),
            reason: reason.clone(),
        }));
        PreparedPart { face_rows: vec![None; part.faces.len()], ..PreparedPart::default() }
    });
    diagnostics.extend(turned.into_iter().map(|t| {
        let (severity, reason) = match t.volume {
            Some(volume) => {
                let faces = t.faces;
                let reason =
                    format!("{faces} connected faces were inside out (volume {volume:.3e} mm³) and were turned");
                (Severity::Note, reason)
            }
            None => (Severity::Warning, format!("{} connected faces of a solid enclose no volume", t.faces)),
        };
        let face = t.volume.is_none().then(|| FaceId::new(t.face));
        let (entity, place) = (part.faces[t.face].entity, face::somewhere(part, &part.faces[t.face]));
        Diagnostic { severity, part: Some(id), face, entity, place, reason }
    }));
    let lost = |face: usize| prepared.face_rows[face].is_none();
    diagnostics.extend(shells::open(part, &free, lost).into_iter().map(|open| Diagnostic {
        severity: Severity::Warning,
        part: Some(id),
        face: Some(FaceId::new(open.face)),
        entity: open.entity,
        place: part.vertices.get(part.edges[open.edge as usize].start.index()).copied(),
        reason: format!(
            "the shell of a solid is open: {} of its {} edges have a face on one side only",
            open.free, open.edges
        ),
    }));
    if borders.width > ROUNDING * size {
        let (pairs, width) = (borders.pairs, borders.width);
        let reason = format!(
            "{pairs} pairs of borders of faces without topology, up to {width:.3e} mm apart, became one edge each"
        );
        let (severity, part) = (Severity::Note, Some(id));
        diagnostics.push(Diagnostic { severity, part, face: None, entity: 0, place: None, reason });
    }
    DonePart { part: prepared, diagnostics, without_area }
}

/// Runs `draft`; a panic costs this face only.
fn guarded<T>(draft: impl FnOnce() -> Result<T, FaceError>) -> Result<T, FaceError> {
    catch_unwind(AssertUnwindSafe(draft)).unwrap_or_else(|panic| Err(FaceError::Internal(panic_message(&*panic))))
}

/// What a panic said, if it said it in text.
pub(crate) fn panic_message(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().copied();
    text.or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("a panic without a text").to_owned()
}

fn scene(model: &Model, clouds: &[Vec<DVec3>], without_area: Vec<Vec<FaceId>>) -> Scene {
    let parts: Vec<ScenePart> = model
        .parts
        .iter()
        .zip(clouds)
        .zip(without_area)
        .map(|((p, cloud), without_area)| {
            let (centre, radius) = extent::centre(cloud).unwrap_or_default();
            let face_colours = p.faces.iter().map(|f| f.colour.or(p.colour)).collect();
            ScenePart { name: p.name.clone(), face_colours, without_area, centre, radius, mesh_of: None }
        })
        .collect();
    let mut first_face = 0;
    let instances = model
        .instances
        .iter()
        .map(|i| {
            let first = first_face;
            first_face += u32::try_from(model.parts[i.part.index()].faces.len()).unwrap_or(0);
            SceneInstance {
                part: i.part.0,
                transform: i.transform,
                colour: i.colour,
                name: i.name.clone(),
                first_face: first,
            }
        })
        .collect();
    Scene { name: model.name.clone(), parts, instances }
}
