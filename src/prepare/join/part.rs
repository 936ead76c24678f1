//! Part -> prepared part: drafts each face, orients all faces, closes them against each other, and reports diagnostics.

use super::against::{take_other_sides, unsure_faces, with_turned_wires};
use super::chains::{Closedness, Sum, TurnedFace};
use super::closing::Closure;
use super::kept::{FaceContent, KeptFace, KeptFaces};
use super::memory::PrepareBudget;
use super::orient::{self, Fault, orient, wanted_sign, wrong_volume};
use super::prepared::{PartCost, PartFacts, PreparedPart};
use super::topology::{self, ClosingOutcome, Unclosed};
use super::{chains, fill, shells};
use crate::control::Call;
use crate::math::boxes::{around, joined};
use crate::model::{
    BorderTrouble, Diagnostic, EdgeId, Face, FaceError, FaceId, FaceTrouble, Part, PartId, Severity, ShellKind,
    ShellTrouble, WireTrouble, surface_points,
};
use crate::prepare::report::{Finding, guarded};
use crate::prepare::sew::sew_edges::{SewSummary, sew};
use crate::prepare::tiles::draft::FaceDraft;
use crate::prepare::tiles::{face, traced};
use crate::prepare::trims::free_edges::{self, FreeFaces, free_face};
use crate::prepare::wires::boundary::{
    self, Boundary, Chain, boundary, is_closed, of_boundary, shared_edges, sign, summed, without_repeats, without_slits,
};
use crate::prepare::wires::heal::{self, Healing};
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Borders no further apart than this share of the part's size are joined without a diagnostic.
const ROUNDING: f64 = 1e-9;

/// A face whose area is at most this share of its squared size has no area.
const NO_AREA: f64 = 1e-9;

/// Prepares a part, with all facts but `hash`, `entities` and `cloud`. `kept`: drafts to take over where faces have the
/// same content; `None` if drafts are not kept.
pub(crate) fn prepare_part(
    id: PartId,
    stated: &Part,
    border_tolerance: f64,
    kept: Option<&KeptFaces<'_>>,
    budget: &PrepareBudget<'_>,
) -> PreparedPart {
    let call = budget.call;
    let size = size_of(call, stated);
    let (trimmed, mut free) = free_edges::free_faces(call, stated, size);
    let mut healings = Vec::new();
    if budget.exceeded() {
        // The whole result will be discarded.
        return PreparedPart::default();
    }
    let (single, repeated) = without_repeats(trimmed);
    let edges = single.edges.len();
    let healed = heal::heal(single, size, &mut healings);
    let gap_edges = edges..healed.edges.len();
    let (sewn, borders) = sew(call, healed, &mut free, border_tolerance * size, &mut healings);
    let part = without_slits(sewn, repeated, &free, &mut healings);
    let part = with_turned_wires(part, &free, &mut healings);
    if budget.exceeded() {
        return PreparedPart::default();
    }
    healings.sort_by_key(|h| h.face);
    // Edges of free trims come after the model's own, and the pieces that sewing makes of them come last.
    let finely_cut = if edges > stated.edges.len() { stated.edges.len() } else { part.edges.len() };
    let mut maker = PartPreparation { call, id, part, free, size, gap_edges, finely_cut, diagnostics: Vec::new() };
    let Drafts { results, cost, kept } = maker.draft(kept, budget);
    if budget.exceeded() {
        call.discard(results);
        call.discard(kept);
        return PreparedPart::default();
    }
    let mut faces = maker.fill(results);
    let mut directed = maker.direct(&mut faces);
    let draft = |part: &Part, face: &Face| {
        let shared = shared_edges(part, &maker.free);
        guarded(|| face::draft(part, face, None, size, &shared, &budget.room))
    };
    let (found, unsure) = take_other_sides(&mut maker.part, &mut faces.drafts, &directed.reversed, draft);
    if found {
        directed = maker.direct(&mut faces);
    }
    if budget.exceeded() {
        call.discard(faces.drafts);
        call.discard(kept);
        return PreparedPart::default();
    }
    let without_area = maker.tell_faces(&mut faces, healings);
    for face in unsure {
        maker.tell(face, Severity::Warning, Finding::new(None, WireTrouble::SideUnsure));
    }
    let has_draft: Vec<bool> = faces.drafts.iter().map(Option::is_some).collect();
    let mut assembled = maker.assemble(faces.drafts, &directed.reversed);
    if budget.exceeded() {
        if let Ok((part, _)) = assembled {
            part.discard(call);
        }
        call.discard(kept);
        return PreparedPart::default();
    }
    if let Err(cause) = &assembled {
        // Assembling panicked where faces share edges. Drop the regions of all faces and fill their loops.
        let mut faces = maker.fill_all(&has_draft, cause);
        directed = maker.direct(&mut faces);
        assembled = maker.assemble(faces.drafts, &directed.reversed);
    }
    let Orientations { sums, mut closedness, turned, .. } = directed;
    let (mut part, lost) = assembled.unwrap_or_else(|cause| maker.nothing(&cause));
    closedness.lose(lost.into_iter().map(|face| of_boundary(&maker.boundary(face))));
    maker.tell_turned(&turned);
    maker.tell_open(&part, &sums);
    maker.tell_sewn(borders);
    let (diagnostics, coincidence) = (maker.diagnostics, maker.part.tolerance);
    part.facts = PartFacts { diagnostics, without_area, closedness, coincidence, cost, kept, ..PartFacts::default() };
    part
}

/// The diagonal of the box around vertices, control points of edges, and points of faces without edges; infinite
/// without any.
fn size_of(call: Call<'_>, part: &Part) -> f64 {
    let of_face = call.each(1, part.faces_without_edges(), |face| around(surface_points(face)));
    let [low, high] = of_face.into_iter().fold(around(part.points_of_edges()), joined);
    (high - low).length()
}

/// A part while it is prepared.
struct PartPreparation<'a> {
    call: Call<'a>,
    id: PartId,
    /// The part after healing and sewing.
    part: Cow<'a, Part>,
    free: FreeFaces,
    size: f64,
    /// Edges that healing added in gaps.
    gap_edges: Range<usize>,
    /// Index of the first edge whose curve is cut much finer than it bends.
    finely_cut: usize,
    diagnostics: Vec<Diagnostic>,
}

/// What drafting the faces of a part gives.
struct Drafts {
    /// `None` for faces lost earlier, which have a diagnostic, or past the budget.
    results: Vec<Option<Result<FaceDraft, FaceError>>>,
    cost: PartCost,
    kept: Vec<KeptFace>,
}

/// The drafts of a part's faces.
struct Faces {
    drafts: Vec<Option<FaceDraft>>,
    /// Why a face has no region.
    causes: BTreeMap<usize, OpenCause>,
}

/// Why a face has no region.
struct OpenCause {
    error: FaceError,
    /// Whether nothing is lost: the face has no area, or its trims keep none of it.
    harmless: bool,
}

/// The report on a filled face.
fn told_filled(cause: &FaceError, area: f64) -> Finding {
    Finding::new(cause.place(), FaceTrouble::Filled { cause: cause.clone(), area_mm2: area })
}

/// Orientation of the faces, and the sums of their chains.
struct Orientations {
    reversed: Vec<bool>,
    /// Sums that are not 0.
    sums: Vec<Sum>,
    closedness: Closedness,
    /// Groups that were flipped, or have no volume.
    turned: Vec<orient::Orientation>,
}

impl PartPreparation<'_> {
    /// Drafts each face on its own, or takes its draft from `kept`, and adds up what they cost.
    fn draft(&self, kept: Option<&KeptFaces<'_>>, budget: &PrepareBudget<'_>) -> Drafts {
        let part = &*self.part;
        let shared = shared_edges(part, &self.free);
        let draft = |(k, (f, free)): (usize, (&Face, &Option<_>))| {
            let span = || tracing::trace_span!("draft", part = self.id.0, face = k, entity = f.entity);
            let work = || {
                span().in_scope(|| guarded(|| face::draft(part, f, free.as_ref(), self.size, &shared, &budget.room)))
            };
            let content = || FaceContent::of(part, f, &shared, self.size);
            let work = || match kept.filter(|_| free.is_none()).and_then(|kept| Some((kept, content()?))) {
                None => (work(), None),
                Some((kept, content)) => match content.find(kept) {
                    Some((draft, kept)) => (Ok(draft), Some(kept.clone())),
                    None => {
                        let draft = work();
                        let kept = draft.as_ref().ok().and_then(|draft| content.keep(draft));
                        (draft, kept)
                    }
                },
            };
            let drafted = (!f.lost && !budget.exceeded()).then(work);
            budget.advance();
            let mut cost = PartCost::default();
            if let Some((Ok(draft), kept)) = &drafted {
                cost = PartCost::of(draft, kept.as_ref());
            }
            budget.spend(cost);
            (drafted, cost)
        };
        let drafted = self.call.each(1, part.faces.iter().zip(&self.free).enumerate(), draft);
        let cost = drafted.iter().fold(PartCost::default(), |sum, (_, cost)| sum.plus(*cost));
        // Collected in place, here and when they are filled: drafts are large.
        let mut all_kept = Vec::new();
        let result = |(drafted, _): (Option<(_, Option<KeptFace>)>, _)| {
            let (result, kept) = drafted?;
            all_kept.extend(kept);
            Some(result)
        };
        let results = drafted.into_iter().map(result).collect();
        Drafts { results, cost, kept: all_kept }
    }

    /// A face's loops as edges.
    fn boundary(&self, face: usize) -> Boundary {
        boundary(&self.part.faces[face], free_face(&self.free, face))
    }

    /// Fills a face in space, with its loops as stated, or each reversed where it runs against `chain`.
    fn filled(&self, face: usize, chain: Option<&Chain>) -> Option<fill::FilledFace> {
        let mut boundary = self.boundary(face);
        if let Some(chain) = chain {
            boundary::turn(&mut boundary, chain);
        }
        guarded(|| Ok(fill::fill(&self.part, &boundary))).ok().flatten()
    }

    /// Fills the faces that could not be drafted. Skips faces without edges, and those without area or refused by the
    /// reader whose edges cancel.
    fn fill(&mut self, results: Vec<Option<Result<FaceDraft, FaceError>>>) -> Faces {
        let mut causes = BTreeMap::new();
        let draft = |(k, result): (usize, Option<Result<FaceDraft, FaceError>>)| match result? {
            Ok(draft) => Some(draft),
            Err(error) => {
                let harmless = matches!(error, FaceError::NoArea { .. } | FaceError::NothingKept);
                causes.insert(k, OpenCause { error, harmless });
                None
            }
        };
        let drafts = results.into_iter().enumerate().map(draft).collect();
        let mut faces = Faces { drafts, causes };
        for (&k, OpenCause { error: e, harmless }) in &mut faces.causes {
            let boundary = self.boundary(k);
            // Edges that cancel do not show what lies between them: a sphere's only edge is its seam.
            let unknown = matches!(e, FaceError::Refused(_)) && of_boundary(&boundary).is_empty();
            if boundary.is_empty() || unknown {
                continue;
            }
            let may_be_none = matches!(e, FaceError::NoArea { .. } | FaceError::Thin { .. });
            if may_be_none && of_boundary(&boundary).is_empty() {
                *harmless = true;
                continue;
            }
            fill::straighten(&mut self.part, &boundary);
            let Some(fill::FilledFace { mut draft, area, size }) = self.filled(k, None) else { continue };
            *harmless = may_be_none && area <= NO_AREA * size * size;
            if !*harmless {
                draft.repairs.push(told_filled(e, area));
            }
            faces.drafts[k] = Some(draft);
        }
        faces
    }

    /// Orients the faces outwards. If a shell's faces do not cancel then, but do with its loops as stated, takes those.
    fn direct(&self, faces: &mut Faces) -> Orientations {
        let mut turned = Vec::new();
        let oriented = guarded(|| Ok(orient(self.call, &self.part, &faces.drafts, &mut turned)));
        let mut reversed = oriented.unwrap_or_else(|_| self.part.faces.iter().map(|face| face.reversed).collect());
        let mut sums = self.sums(&faces.drafts, &reversed);
        if !sums.is_empty() {
            let stuck: BTreeSet<u32> = sums.iter().filter(|s| self.is_stuck(s)).map(|s| s.shell).collect();
            if !stuck.is_empty() {
                // A panic leaves faces as stated up to then, which the sums below count.
                _ = guarded(|| {
                    self.take_at_word(stuck, faces, &mut reversed, &turned);
                    Ok(())
                });
            }
            sums = self.sums(&faces.drafts, &reversed);
            if self.close_gaps(&sums, faces, &reversed) {
                sums = self.sums(&faces.drafts, &reversed);
            }
        }
        let mut loops_close = true;
        for (k, face) in self.part.faces.iter().enumerate() {
            let whole = faces.drafts[k].is_some() || faces.causes.get(&k).is_some_and(|cause| cause.harmless);
            loops_close &= whole && !face.lost && is_closed(&self.part, face, free_face(&self.free, k));
        }
        let open: BTreeSet<u32> = sums.iter().map(|s| s.shell).collect();
        for (face, draft) in self.part.faces.iter().zip(&mut faces.drafts) {
            if let Some(draft) = draft {
                draft.ends_with_surface &= open.contains(&face.shell);
            }
        }
        let closedness = Closedness::of(&sums, loops_close);
        Orientations { reversed, sums, closedness, turned }
    }

    fn sums(&self, drafts: &[Option<FaceDraft>], reversed: &[bool]) -> Vec<Sum> {
        chains::sums(
            self.part.edges.len(),
            drafts.iter().enumerate().filter_map(|(face, draft)| {
                let chain = &draft.as_ref()?.chain[..];
                Some(TurnedFace { face, shell: self.part.faces[face].shell, reversed: reversed[face], chain })
            }),
        )
    }

    /// Whether faces do not cancel on an edge with an even number of uses. Excludes edges that healing added.
    fn is_stuck(&self, sum: &Sum) -> bool {
        !sum.is_free() && !self.gap_edges.contains(&(sum.edge as usize))
    }

    /// Takes the loops of these shells as stated, if the faces of a shell cancel then.
    fn take_at_word(
        &self,
        mut shells: BTreeSet<u32>,
        faces: &mut Faces,
        reversed: &mut [bool],
        turned: &[orient::Orientation],
    ) {
        let part = &*self.part;
        let shell = |k: usize| part.faces[k].shell;
        let drafted = (0..part.faces.len()).filter(|&k| shells.contains(&shell(k)) && faces.drafts[k].is_some());
        let stated: Vec<(usize, Chain)> = drafted.map(|k| (k, of_boundary(&self.boundary(k)))).collect();
        let rows = stated.iter().map(|(k, chain)| {
            let (face, reversed) = (*k, part.faces[*k].reversed);
            TurnedFace { face, shell: shell(face), reversed, chain }
        });
        for sum in chains::sums(part.edges.len(), rows).iter().filter(|s| self.is_stuck(s)) {
            shells.remove(&sum.shell);
        }
        for (k, chain) in stated.into_iter().filter(|(k, _)| shells.contains(&shell(*k))) {
            reversed[k] = part.faces[k].reversed;
            if faces.drafts[k].as_ref().is_none_or(|draft| draft.chain == chain) {
                continue;
            }
            let again = guarded(|| match face::draft_as_stated(part, &part.faces[k], self.size)? {
                draft if draft.chain == chain => Ok(draft),
                _ => Err(FaceError::Internal("its loops cannot be kept as stated".to_owned())),
            });
            let filled = |cause: FaceError| {
                let fill::FilledFace { mut draft, area, .. } = self.filled(k, None)?;
                draft.repairs.push(told_filled(&cause, area));
                Some(draft)
            };
            if let Some(mut draft) = again.map_or_else(filled, Some) {
                draft.repairs.push(Finding::new(None, FaceTrouble::LoopAsStated));
                faces.drafts[k] = Some(draft);
            }
        }
        let mut groups: BTreeMap<u32, Vec<(usize, bool)>> = BTreeMap::new();
        for k in (0..part.faces.len()).filter(|&k| shells.contains(&shell(k))) {
            groups.entry(shell(k)).or_default().push((k, reversed[k]));
        }
        let bodies = turned.iter().filter(|t| t.fault == Fault::VoidOutside).map(|t| shell(t.face));
        let bodies: BTreeSet<u32> = bodies.collect();
        for (shell, group) in groups {
            let Some(wanted) = wanted_sign(part, shell) else { continue };
            let wanted = if bodies.contains(&shell) { 1.0 } else { wanted };
            if wrong_volume(self.call, &faces.drafts, &group, reversed, wanted).is_some_and(|volume| volume != 0.0) {
                group.iter().for_each(|&(k, _)| reversed[k] = !reversed[k]);
            }
        }
    }

    /// Adds leftover gap edges that form closed chains to one face per shell. Returns whether there were any.
    fn close_gaps(&self, sums: &[Sum], faces: &mut Faces, reversed: &[bool]) -> bool {
        let mut found = false;
        for of_shell in sums.chunk_by(|a, b| a.shell == b.shell) {
            let gaps: Vec<&Sum> = of_shell.iter().filter(|s| self.gap_edges.contains(&(s.edge as usize))).collect();
            let mut ends: BTreeMap<u32, i32> = BTreeMap::new();
            for gap in &gaps {
                let edge = &self.part.edges[gap.edge as usize];
                *ends.entry(edge.start.0).or_default() -= gap.sum;
                *ends.entry(edge.end.0).or_default() += gap.sum;
            }
            let Some(first) = gaps.first().filter(|_| ends.values().all(|&count| count == 0)) else { continue };
            let face = first.faces[0] as usize;
            let Some(draft) = &mut faces.drafts[face] else { continue };
            draft.chain.extend(gaps.iter().map(|gap| (gap.edge, -sign(reversed[face]) * gap.sum)));
            draft.chain = summed(std::mem::take(&mut draft.chain));
            let what = WireTrouble::BridgesFilled { edges: gaps.len() };
            draft.repairs.push(Finding::at_edge(&self.part, first.edge, what));
            found = true;
        }
        found
    }

    fn tell(&mut self, face: usize, severity: Severity, told: Finding) -> &mut Diagnostic {
        let stated = &self.part.faces[face];
        let Finding { edge, place, what: kind } = told;
        let place = place.or_else(|| traced::somewhere(&self.part, stated));
        let (part, entity, face) = (Some(self.id), stated.entity, Some(FaceId::new(face)));
        let row = self.diagnostics.len();
        self.diagnostics.push(Diagnostic { severity, part, face, edge, entity, place, kind });
        &mut self.diagnostics[row]
    }

    /// Reports the diagnostics of each face, and returns the faces without area.
    fn tell_faces(&mut self, faces: &mut Faces, healings: Vec<Healing>) -> Vec<FaceId> {
        let mut without_area = Vec::new();
        let mut healings = healings.into_iter().peekable();
        for (k, draft) in faces.drafts.iter_mut().enumerate() {
            let cause = faces.causes.get(&k);
            if draft.is_none() && cause.is_none() {
                // Lost earlier, and already reported. Its repairs must not hold up those of later faces.
                while healings.next_if(|h| h.face == k).is_some() {}
                continue;
            }
            while let Some(healing) = healings.next_if(|h| h.face == k) {
                match (&mut *draft, healing.severity) {
                    (Some(draft), Severity::Warning) => draft.repairs.push(healing.told),
                    _ => _ = self.tell(k, healing.severity, healing.told),
                }
            }
            if let Some(draft) = draft {
                for told in &draft.repairs {
                    self.tell(k, Severity::Warning, told.clone());
                }
                for note in &draft.notes {
                    self.tell(k, Severity::Note, Finding::new(None, note.clone()));
                }
            }
            match cause {
                Some(OpenCause { error, harmless: true }) => {
                    self.tell(k, Severity::Note, Finding::new(None, FaceTrouble::Unusable(error.clone())));
                    without_area.push(FaceId::new(k));
                }
                Some(OpenCause { error, .. }) if draft.is_none() => {
                    let told = Finding::new(error.place(), FaceTrouble::Unusable(error.clone()));
                    self.tell(k, Severity::Error, told);
                }
                _ => {}
            }
        }
        without_area
    }

    /// Fills all faces that had a draft, after these could not be assembled.
    fn fill_all(&mut self, has_draft: &[bool], cause: &FaceError) -> Faces {
        let mut faces = Faces { drafts: Vec::with_capacity(has_draft.len()), causes: BTreeMap::new() };
        for (k, &has_draft) in has_draft.iter().enumerate() {
            let boundary = self.boundary(k);
            fill::straighten(&mut self.part, &boundary);
            if !has_draft {
                faces.drafts.push(None);
                continue;
            }
            let filled = self.filled(k, None);
            let (severity, told) = match &filled {
                Some(filled) => (Severity::Warning, told_filled(cause, filled.area)),
                None => (Severity::Error, Finding::new(None, FaceTrouble::Unusable(cause.clone()))),
            };
            self.tell(k, severity, told.clone());
            faces.drafts.push(filled.map(|fill::FilledFace { mut draft, .. }| {
                draft.repairs.push(told);
                draft
            }));
        }
        faces
    }

    /// Assembles the drafts. Returns the part, and the faces whose loops could not be closed.
    ///
    /// # Errors
    /// A panic outside of the work on single faces: on edges, which faces share.
    fn assemble(
        &mut self,
        drafts: Vec<Option<FaceDraft>>,
        reversed: &[bool],
    ) -> Result<(PreparedPart, Vec<usize>), FaceError> {
        let mut told = Vec::new();
        let refill = |k: usize, chain: &Chain| {
            let mut draft = self.filled(k, Some(chain))?.draft;
            draft.chain.clone_from(chain);
            Some(draft)
        };
        let assemble =
            || topology::assemble(self.call, &self.part, self.finely_cut, drafts, reversed, refill, &mut told);
        let prepared = guarded(|| Ok(assemble()))?;
        let lost =
            told.iter().filter(|(_, closed)| matches!(closed, ClosingOutcome::Lost(_))).map(|(k, _)| *k).collect();
        self.tell_closed(told);
        Ok((prepared, lost))
    }

    /// A part without tiles, with a diagnostic for each face.
    fn nothing(&mut self, cause: &FaceError) -> (PreparedPart, Vec<usize>) {
        let faces = self.part.faces.len();
        for k in 0..faces {
            self.tell(k, Severity::Error, Finding::new(None, FaceTrouble::Unusable(cause.clone())));
        }
        (PreparedPart { face_rows: vec![None; faces], ..PreparedPart::default() }, (0..faces).collect())
    }

    fn tell_closed(&mut self, told: Vec<(usize, ClosingOutcome)>) {
        for (k, closed) in told {
            let (severity, place, what) = match closed {
                ClosingOutcome::Closure(Closure { loops, joints, longest, place }) if loops > 0 => {
                    (Severity::Warning, place, FaceTrouble::TilesClosed { loops, joints, longest_mm: longest })
                }
                ClosingOutcome::Closure(Closure { joints, longest, place, .. }) => {
                    (Severity::Note, place, FaceTrouble::EndsJoined { joints, longest_mm: longest })
                }
                ClosingOutcome::Filled(Unclosed::Loops) => (Severity::Warning, None, FaceTrouble::TilesFilled),
                ClosingOutcome::Lost(Unclosed::Loops) => (Severity::Error, None, FaceTrouble::TilesLost),
                ClosingOutcome::Filled(Unclosed::Panic(cause)) => {
                    let area_mm2 = self.filled(k, None).map_or(0.0, |filled| filled.area);
                    (Severity::Warning, None, FaceTrouble::Filled { cause, area_mm2 })
                }
                ClosingOutcome::Lost(Unclosed::Panic(cause)) => (Severity::Error, None, FaceTrouble::Unusable(cause)),
            };
            self.tell(k, severity, Finding::new(place, what));
        }
    }

    fn tell_turned(&mut self, turned: &[orient::Orientation]) {
        for t in turned {
            let faces = t.faces;
            let (severity, kind) = match t.fault {
                Fault::InsideOut { volume: volume_mm3 } => {
                    // One wrong sense does that, too, where the face could be the other side of its wires.
                    let is_sure = unsure_faces(&self.part, self.part.faces[t.face].shell).is_empty();
                    let severity = if is_sure { Severity::Note } else { Severity::Warning };
                    (severity, ShellTrouble::InsideOut { faces, volume_mm3 })
                }
                Fault::VoidOutside => (Severity::Note, ShellTrouble::VoidOutside { faces }),
                Fault::NoVolume => (Severity::Warning, ShellTrouble::NoVolume { faces }),
            };
            let told = self.tell(t.face, severity, Finding::new(None, kind));
            told.face = told.face.filter(|_| t.fault == Fault::NoVolume);
        }
    }

    /// Reports open shells, and edges on which faces cannot be oriented to cancel.
    fn tell_open(&mut self, prepared: &PreparedPart, sums: &[Sum]) {
        let lost = |face: usize| prepared.face_rows[face].is_none();
        for shells::Open { entity, free, edges, edge, face } in shells::open(&self.part, &self.free, lost) {
            let told = Finding::at_edge(&self.part, edge, ShellTrouble::Open { free, edges });
            self.tell(face, Severity::Warning, told).entity = entity;
        }
        for of_shell in sums.chunk_by(|a, b| a.shell == b.shell) {
            let solid = self.part.shells.get(of_shell[0].shell as usize).is_some_and(|s| s.kind != ShellKind::Open);
            // An edge of more than two sheets does not determine their orientation.
            let mut stuck = of_shell.iter().filter(|s| !s.is_free() && (solid || s.uses == 2));
            let Some(first) = stuck.next() else { continue };
            let severity = if solid { Severity::Warning } else { Severity::Note };
            let (edges, faces) = (1 + stuck.count(), first.faces.map(FaceId));
            let kind = ShellTrouble::NotOrientable { edges, edge: EdgeId(first.edge), faces };
            self.tell(faces[0].index(), severity, Finding::at_edge(&self.part, first.edge, kind));
        }
    }

    fn tell_sewn(&mut self, borders: SewSummary) {
        if borders.width > ROUNDING * self.size {
            let kind = BorderTrouble::Joined { pairs: borders.pairs, width_mm: borders.width };
            self.diagnostics.push(Diagnostic { part: Some(self.id), ..Diagnostic::new(Severity::Note, kind) });
        }
    }
}

#[cfg(test)]
mod tests;
