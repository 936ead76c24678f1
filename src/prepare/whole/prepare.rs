//! Model -> prepared model: its parts in parallel, then the scene, the box and the weights of tiles.

use super::{extent, weight};
use crate::control::{Call, Control, Jobs, Rayon};
use crate::mesh::{Scene, SceneInstance, ScenePart};
use crate::model::{Diagnostic, DiagnosticKind, FaceId, Instance, Model, Part, PartId, Severity};
use crate::prepare::join::chains::Closedness;
use crate::prepare::join::limits::{PrepareBudget, PrepareError, PrepareLimits};
use crate::prepare::join::part::{PartOutcome, prepare_part};
use crate::prepare::join::prepared::Prepared;
use glam::DVec3;
use std::sync::Arc;

/// Options of [`prepare`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PrepareOptions {
    /// Upper limits on patches and memory.
    pub limits: PrepareLimits,
    /// Distance up to which borders merge into one edge, as a share of the part's diagonal; 0 disables it. Applies to
    /// faces without topology (untrimmed, or with free trims) in parts that state no [tolerance](Part::tolerance).
    pub border_tolerance: f64,
}

impl PrepareOptions {
    /// [`PrepareLimits::DEFAULT`], and a border tolerance of 1e-6, for coordinates of seven digits.
    pub const DEFAULT: Self = Self { limits: PrepareLimits::DEFAULT, border_tolerance: 1e-6 };

    /// Sets [`limits`](Self::limits).
    #[must_use]
    pub const fn with_limits(mut self, limits: PrepareLimits) -> Self {
        self.limits = limits;
        self
    }

    /// Sets [`border_tolerance`](Self::border_tolerance).
    #[must_use]
    pub const fn with_border_tolerance(mut self, border_tolerance: f64) -> Self {
        self.border_tolerance = border_tolerance;
        self
    }
}

impl Default for PrepareOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Prepares a model for tessellation.
///
/// A face that cannot be used, or whose work panics, is reported in [`Prepared::diagnostics`]; its neighbours are
/// unaffected. After a panic on edges, which faces share, all faces of the part are filled in space. The result does
/// not depend on the number of threads. Cost: about 20–200 µs per face. Runs on [`Rayon`]'s threads.
///
/// # Errors
/// If the model exceeds [`PrepareOptions::limits`]. Work stops as soon as it does.
pub fn prepare(mut model: Model, options: &PrepareOptions) -> Result<Prepared, PrepareError> {
    let diagnostics = std::mem::take(&mut model.diagnostics);
    prepare_all(Call::new(&Rayon, &Control::default()), &model, diagnostics, options)
}

/// As [`prepare`], on the threads of `jobs`, with progress and cancellation, and from a model that is kept. Cancelling
/// takes effect between faces, and between the steps of a part.
///
/// # Errors
/// As [`prepare`], and [`PrepareError::Cancelled`].
pub fn prepare_on(
    jobs: &dyn Jobs,
    model: &Model,
    options: &PrepareOptions,
    control: &Control,
) -> Result<Prepared, PrepareError> {
    prepare_all(Call::new(jobs, control), model, model.diagnostics.clone(), options)
}

/// `diagnostics` are those of reading.
fn prepare_all(
    call: Call<'_>,
    model: &Model,
    mut diagnostics: Vec<Diagnostic>,
    options: &PrepareOptions,
) -> Result<Prepared, PrepareError> {
    let budget = PrepareBudget::new(options.limits, model, call);
    let parts = model.parts.len();
    let unknown = model.instances.iter().filter(|i| i.part.index() >= parts);
    diagnostics.extend(unknown.map(|i| {
        let kind = DiagnosticKind::NoPart { instance: i.name.to_string(), part: i.part, parts };
        Diagnostic::new(Severity::Error, kind)
    }));
    budget.hold(model);
    if budget.exceeded() {
        return Err(budget.error(model));
    }
    let of_part = |(k, part): (usize, &Part)| prepare_part(PartId::new(k), part, options.border_tolerance, &budget);
    let done: Vec<PartOutcome> = call.each(1, model.parts.iter().enumerate(), of_part);
    if budget.exceeded() {
        call.each(1, done, |done| done.part.discard(call));
        return Err(budget.error(model));
    }
    let mut parts = Vec::with_capacity(done.len());
    let mut facts = Vec::with_capacity(done.len());
    for part in done {
        parts.push(Arc::new(part.part));
        diagnostics.extend(part.diagnostics);
        facts.push((part.without_area, part.closedness));
    }
    let clouds = call.each(1, &parts, |part| if call.is_cancelled() { Vec::new() } else { extent::cloud(part) });
    let scene = scene(model, &clouds, facts);
    let bounds = extent::placed_box(&clouds, &scene.instances);
    let diagonal = bounds.map_or(0.0, |[low, high]| (high - low).length());
    let scales = scene.largest_scales();
    call.each(1, parts.iter_mut().zip(scales), |(part, scale)| {
        let part = Arc::get_mut(part).expect("a part that was just made has one owner");
        if !call.is_cancelled() {
            weight::weigh(call, part, diagonal / scale);
        }
    });
    if call.is_cancelled() {
        call.each(1, parts.into_iter().filter_map(Arc::into_inner), |part| part.discard(call));
        return Err(PrepareError::Cancelled);
    }
    Ok(Prepared { parts, scene, diagnostics, bounds, diagonal })
}

fn scene(model: &Model, clouds: &[Vec<DVec3>], facts: Vec<(Vec<FaceId>, Closedness)>) -> Scene {
    let parts: Vec<ScenePart> = model
        .parts
        .iter()
        .zip(clouds)
        .zip(facts)
        .map(|((p, cloud), (without_area, closedness))| {
            let (centre, radius) = extent::centre(cloud).unwrap_or_default();
            let face_colours = p.faces.iter().map(|f| f.colour.or(p.colour)).collect();
            let Closedness { free_edges, not_orientable, closed } = closedness;
            ScenePart {
                name: p.name.clone(),
                face_colours,
                without_area,
                free_edges,
                not_orientable,
                closed,
                centre,
                radius,
                mesh_of: None,
            }
        })
        .collect();
    let mut first_face = 0;
    let place = |i: &Instance| {
        let faces = model.parts.get(i.part.index())?.faces.len();
        let first = first_face;
        first_face += u32::try_from(faces).unwrap_or(0);
        let Instance { part, transform, colour, name, assembly } = i.clone();
        Some(SceneInstance { part, transform, colour, name, assembly, first_face: first })
    };
    let instances = model.instances.iter().filter_map(place).collect();
    Scene { name: model.name.clone(), parts, instances }
}
