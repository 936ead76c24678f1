//! Model -> prepared model: parts that another prepared model has are taken over, the others prepared in parallel; then
//! the scene, the box and the weights of tiles.

use super::{extent, weight};
use crate::control::{Call, Control, Jobs, Rayon};
use crate::math::keyed::matched;
use crate::mesh::{Scene, SceneInstance, ScenePart};
use crate::model::{Diagnostic, DiagnosticKind, Model, Part, PartId, Severity};
use crate::prepare::join::chains::Closedness;
use crate::prepare::join::content::{ContentHash, entities};
use crate::prepare::join::kept;
use crate::prepare::join::memory::{PrepareBudget, PrepareError, PrepareLimits};
use crate::prepare::join::part::prepare_part;
use crate::prepare::join::prepared::{PartFacts, Prepared, PreparedPart};
use std::sync::Arc;

/// Options of [`prepare`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PrepareOptions {
    /// Upper limits on patches and memory.
    pub limits: PrepareLimits,
    /// Distance up to which borders merge into one edge, as a share of the part's diagonal; 0 disables it (in C, 0 is
    /// the default). Applies to faces without topology (untrimmed, or with free trims) in parts that state no
    /// [tolerance](Part::tolerance), and, besides that tolerance, to edges of faces in open shells. From 0 to 1.
    pub border_tolerance: f64,
    /// Whether to keep the drafts of faces, and to take them over for faces of a changed part in an
    /// [update](Prepared::update). A part has them if the call that prepared it had this option; a part that is taken
    /// over whole stays as it is. Not for faces with free trims. Costs memory, a seventh of the prepared model
    /// ([`PreparedMemory::update`](crate::prepare::PreparedMemory::update)).
    pub keep_faces: bool,
}

impl PrepareOptions {
    /// [`PrepareLimits::DEFAULT`], a border tolerance of 1e-6, for coordinates of seven digits, and no faces kept.
    pub const DEFAULT: Self = Self { limits: PrepareLimits::DEFAULT, border_tolerance: 1e-6, keep_faces: false };
}

options! {
    PrepareOptions:
    with_limits(limits: PrepareLimits);
    with_border_tolerance(border_tolerance: f64);
    with_keep_faces(keep_faces: bool);
}

/// Prepares a model for tessellation: an [update](Prepared::update) of nothing.
///
/// A face that cannot be used, or whose work panics, is reported in [`Prepared::diagnostics`]; its neighbours are
/// unaffected. After a panic on edges, which faces share, all faces of the part are filled in space. The result does
/// not depend on the number of threads, unless near the limit of memory. Cost: about 20–200 µs per face. Runs on
/// [`Rayon`]'s threads.
///
/// # Errors
/// If the model exceeds [`PrepareOptions::limits`]: work stops as soon as it does. If an option is out of range.
pub fn prepare(model: Model, options: &PrepareOptions) -> Result<Prepared, PrepareError> {
    Prepared::default().update(model, options)
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
    Prepared::default().update_on(jobs, model, options, control)
}

impl Prepared {
    /// Prepares another model, and takes over the parts that both have: those with the same content, bit for bit,
    /// wherever they stand in the lists, if the border tolerance is the same. Names and colours may differ, and entity
    /// numbers, but for those in the cause for which a face was refused.
    ///
    /// Gives what [`prepare`] does: the same parts, scene and diagnostics. Only how tiles are shared among workers may
    /// differ, because a part that is taken over keeps the expected costs of its tiles. Its data is shared with `self`,
    /// which does not change and may be dropped; it is copied if its entity numbers have changed, and prepared again
    /// if these do not tell which was which.
    ///
    /// Cost: that of [`prepare`] for the other parts; for all parts, a nanosecond per byte of the model to compare
    /// them, and the box of the placed model.
    ///
    /// # Errors
    /// As [`prepare`]. Parts that are taken over count towards the limits with what they needed when they were
    /// prepared.
    pub fn update(&self, mut model: Model, options: &PrepareOptions) -> Result<Self, PrepareError> {
        let diagnostics = std::mem::take(&mut model.diagnostics);
        let control = Control::default();
        let call = Call::new(&Rayon, &control);
        let updated = update(call, &self.parts, &model, diagnostics, options);
        call.each_by_size(
            model.parts,
            |part| part.faces.len(),
            |part| {
                call.discard(part.faces);
                call.discard(part.edges);
            },
        );
        updated
    }

    /// As [`update`](Self::update), on the threads of `jobs`, with progress and cancellation, and from a model that is
    /// kept. Progress counts the faces of parts that are not taken over.
    ///
    /// # Errors
    /// As [`prepare_on`].
    pub fn update_on(
        &self,
        jobs: &dyn Jobs,
        model: &Model,
        options: &PrepareOptions,
        control: &Control,
    ) -> Result<Self, PrepareError> {
        update(Call::new(jobs, control), &self.parts, model, model.diagnostics.clone(), options)
    }
}

/// A part of the new model.
enum Source {
    TakenOver(Arc<PreparedPart>),
    /// With its hash, if it was compared.
    Changed(Option<ContentHash>),
}

/// The hash of a part's content; any, once cancelled.
fn hash_of(call: Call<'_>, part: &Part, options: &PrepareOptions) -> ContentHash {
    if call.is_cancelled() { ContentHash::default() } else { ContentHash::of(part, options.border_tolerance) }
}

/// Finds the parts of `model` among those `before`. Compares nothing if there are none.
fn compare(call: Call<'_>, before: &[Arc<PreparedPart>], model: &Model, options: &PrepareOptions) -> Vec<Source> {
    if before.is_empty() {
        return model.parts.iter().map(|_| Source::Changed(None)).collect();
    }
    let old: Vec<ContentHash> = before.iter().map(|part| part.facts.hash).collect();
    let new = call.each_by_size(&model.parts, |part| part.faces.len(), |part| hash_of(call, part, options));
    let rows = matched(&old, &new);
    let source = |((row, hash), part): ((Option<usize>, ContentHash), &Part)| {
        let same = row.and_then(|row| before[row].renumbered(entities(part)));
        same.map_or(Source::Changed(Some(hash)), Source::TakenOver)
    };
    call.each(1, rows.into_iter().zip(new).zip(&model.parts), source)
}

/// `diagnostics` are those of reading.
fn update(
    call: Call<'_>,
    before: &[Arc<PreparedPart>],
    model: &Model,
    mut diagnostics: Vec<Diagnostic>,
    options: &PrepareOptions,
) -> Result<Prepared, PrepareError> {
    let asked = options.border_tolerance;
    if !(0.0..=1.0).contains(&asked) {
        return Err(PrepareError::BorderTolerance { asked });
    }
    let sources = compare(call, before, model, options);
    let changed = model.parts.iter().zip(&sources).filter(|(_, source)| matches!(source, Source::Changed(_)));
    let budget = PrepareBudget::new(options.limits, changed.map(|(part, _)| part.faces.len() as u64).sum(), call);
    let parts = model.parts.len();
    let unknown = model.instances.iter().filter(|i| i.part.index() >= parts);
    diagnostics.extend(unknown.map(|i| {
        let kind = DiagnosticKind::NoPart { instance: i.name.to_string(), part: i.part, parts };
        Diagnostic::new(Severity::Error, kind)
    }));
    budget.hold(model);
    for source in &sources {
        if let Source::TakenOver(part) = source {
            budget.spend(part.facts.cost);
        }
    }
    if budget.exceeded() {
        return Err(budget.error(model));
    }
    let known = before.iter().flat_map(|part| &part.facts.kept);
    let some_changed = sources.iter().any(|source| matches!(source, Source::Changed(_)));
    let kept = (options.keep_faces && some_changed).then(|| kept::by_content(known));
    let of_part = |(k, (part, source)): (usize, (&Part, Source))| match source {
        Source::TakenOver(part) => part,
        Source::Changed(known) => {
            let prepare = || prepare_part(PartId::new(k), part, options.border_tolerance, kept.as_ref(), &budget);
            let (mut prepared, hash) = match known {
                Some(hash) => (prepare(), hash),
                // Meanwhile: some of the preparation is done by one thread.
                None => call.both(prepare, || hash_of(call, part, options)),
            };
            let cloud = if call.is_cancelled() { Vec::new() } else { extent::cloud(call, &prepared) };
            prepared.facts = PartFacts { hash, entities: entities(part), cloud, ..prepared.facts };
            Arc::new(prepared)
        }
    };
    let faces = |(_, (part, _)): &(usize, (&Part, Source))| part.faces.len();
    let mut parts = call.each_by_size(model.parts.iter().zip(sources).enumerate(), faces, of_part);
    if budget.exceeded() {
        discard(call, parts);
        return Err(budget.error(model));
    }
    for (k, part) in parts.iter().enumerate() {
        let own = part.facts.diagnostics.iter().cloned();
        diagnostics.extend(own.map(|told| Diagnostic { part: Some(PartId::new(k)), ..told }));
    }
    let scene = scene(model, &parts);
    let bounds = extent::placed_box(&parts, &scene.instances);
    let diagonal = bounds.map_or(0.0, |[low, high]| (high - low).length());
    call.each(1, parts.iter_mut().zip(scene.largest_scales()), |(part, scale)| {
        // Parts that were taken over as they are have another owner, and weights.
        if let (Some(part), false) = (Arc::get_mut(part), call.is_cancelled()) {
            weight::weigh(call, part, diagonal / scale);
        }
    });
    if call.is_cancelled() {
        discard(call, parts);
        return Err(PrepareError::Cancelled);
    }
    Ok(Prepared { parts: Arc::new(parts), scene, diagnostics, bounds, diagonal })
}

/// Frees parts that nobody else has on all threads.
fn discard(call: Call<'_>, parts: Vec<Arc<PreparedPart>>) {
    call.each(1, parts.into_iter().filter_map(Arc::into_inner), |part| part.discard(call));
}

fn scene(model: &Model, prepared: &[Arc<PreparedPart>]) -> Scene {
    let part = |(stated, prepared): (&Part, &Arc<PreparedPart>)| {
        let PartFacts { without_area, closedness, cloud, .. } = &prepared.facts;
        let (centre, radius) = extent::centre(cloud).unwrap_or_default();
        let Closedness { free_edges, not_orientable, closed } = closedness.clone();
        ScenePart {
            name: stated.name.clone(),
            face_colours: stated.faces.iter().map(|f| f.colour.or(stated.colour)).collect(),
            without_area: without_area.clone(),
            free_edges,
            not_orientable,
            closed,
            centre,
            radius,
            mesh_of: None,
            key: None,
        }
    };
    let parts = model.parts.iter().zip(prepared).map(part).collect();
    let of_known_parts = model.instances.iter().filter(|i| i.part.index() < model.parts.len());
    let mut scene =
        Scene { name: model.name.clone(), parts, instances: of_known_parts.map(SceneInstance::from).collect() };
    scene.number_faces(0);
    scene
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::{Alone, assert_each_cancels};
    use crate::model::shapes;

    #[test]
    fn prepares_are_cancelled_wherever_they_look() {
        let model = shapes::all();
        assert_each_cancels("shapes", 300, |control| {
            let prepared = prepare_on(&Alone, &model, &PrepareOptions::DEFAULT, control);
            matches!(prepared, Err(PrepareError::Cancelled))
        });
    }
}
