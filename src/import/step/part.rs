//! Gathered shells and bodies -> one part: shared vertices and edges, faces with oriented loops, diagnostics of
//! failures.

use super::body::append;
use super::budget::Net;
use super::contents::{PartContents, ShellUse, Source, merge_loose_shells};
use super::curve::{BoundedCurve, Carrier, straight};
use super::draft::{Corners, EdgeDraft, EdgeDrafts, head_to_tail};
use super::face_location::Stated;
use super::face_surface::{FaceJob, Reader};
use super::loops::{Bound, EdgeKey, StatedFace, StatedUse, VertexKey};
use super::place::Geometry;
use super::spline;
use super::table::{Read, Trouble, missing};
use super::units::{Ends, Units, Whole};
use super::values::{Map, Set};
use crate::control::Call;
use crate::model::{
    Coedge, Colour, Diagnostic, Edge, EdgeId, Face, FaceId, Frame3, Loop, Part, PartError, Severity, Shell, StepCause,
    StepOutcome, StepTrouble, Surface, VertexId,
};
use glam::DVec3;

/// Curves by number: units, the carrier, and whether the curve has the carrier's direction.
type Carriers = Map<u64, (Units, (Carrier, bool))>;

impl Reader<'_> {
    /// Reads the faces of shells and bodies. The diagnostics do not state a part yet.
    pub(super) fn part(&self, name: &str, gathered: &PartContents, colour: Option<Colour>) -> (Part, Vec<Diagnostic>) {
        let shells = gathered.shells.as_slice();
        let (numbers, merged) = merge_loose_shells(shells);
        let jobs: Vec<FaceJob<'_>> = numbers
            .into_iter()
            .zip(shells)
            .flat_map(|(i, shell)| shell.faces.iter().map(move |(source, turned)| (i, shell, *source, *turned)))
            .collect();
        let budget = &self.table.budget;
        let names: usize = jobs.iter().filter_map(|job| Some(self.table.find(job.2.id())?.label().len())).sum();
        if !budget.spend(jobs.len().saturating_mul(BYTES_PER_FACE).saturating_add(names)) {
            // The whole result will be discarded.
            return <(Part, Vec<Diagnostic>)>::default();
        }
        let stopped = || self.call.is_cancelled();
        let stated: Vec<Read<StatedFace>> = self.call.each(16, &jobs, |(_, shell, source, _)| {
            if stopped() {
                return Err(Trouble::new(source.id(), StepTrouble::Unread { what: "the face" }));
            }
            self.geometry(shell.units).stated_face(*source)
        });
        let edges = self.edges(&jobs, &stated);
        if stopped() {
            return <(Part, Vec<Diagnostic>)>::default();
        }
        let mut assembly = Assembly::new(self.call, name.to_owned(), shells, merged, colour, edges);
        stated.iter().flatten().take_while(|_| !stopped()).for_each(|face| assembly.meet(face));
        for id in assembly.run_against(&stated) {
            let Some(Ok(draft)) = assembly.edges.get_mut(EdgeKey::Curve(id)) else { continue };
            let Some(exchanged) = self.exchanged(id, draft) else { continue };
            *draft = exchanged;
            let place = Some(draft.points[0]);
            assembly.say(Severity::Warning, id, place, StepOutcome::VerticesExchanged);
        }
        assembly.settle_closed(&stated);
        let surfaces = self.surfaces(&jobs, &stated, &assembly.edges);
        assembly.part.faces.reserve_exact(jobs.len());
        let faces = jobs.into_iter().zip(stated).zip(surfaces);
        for (((shell_index, shell, source, turned), face), surface) in faces.take_while(|_| !stopped()) {
            let geometry = self.geometry(shell.units);
            let read = face.and_then(|face| match surface {
                Some(surface) => assembly.face(&geometry, face, surface, source),
                None => Err(Trouble::new(source.id(), StepTrouble::Unread { what: "its surface" })),
            });
            let (lost, none) = (read.is_err(), Surface::Plane { frame: Frame3::WORLD });
            let (surface, refused, loops, against) = match read {
                Ok((Ok(surface), loops, against)) => (surface, None, loops, against),
                Ok((Err(cause), loops, against)) => (none, Some(cause), loops, against),
                Err(trouble) => {
                    assembly.lose(&geometry, source, &trouble);
                    (none, None, Vec::new(), false)
                }
            };
            assembly.part.faces.push(Face {
                surface,
                loops,
                trims: None,
                reversed: against != turned,
                shell: shell_index,
                colour: self.colour(source.id()).or(shell.colour),
                name: self.table.find(source.id()).map(|i| i.label().to_owned()).unwrap_or_default(),
                entity: source.id(),
                lost,
                refused,
            });
        }
        for (part, diagnostics) in self.call.each(1, &gathered.bodies, |body| self.body(body)) {
            assembly.diagnostics.extend(diagnostics);
            append(&mut assembly.part, part);
        }
        assembly.finish()
    }

    /// Reads every edge that the faces use, once.
    fn edges(&self, jobs: &[FaceJob<'_>], stated: &[Read<StatedFace>]) -> EdgeDrafts {
        let mut places: Map<EdgeKey, usize> = Map::default();
        let mut order: Vec<(EdgeKey, Units, u64, Whole)> = Vec::new();
        for ((_, shell, ..), face) in jobs.iter().zip(stated).take_while(|_| !self.call.is_cancelled()) {
            let Ok(face) = face else { continue };
            for uses in face.bounds.iter().map(Bound::uses) {
                let whole = self.geometry(shell.units).whole(uses);
                for edge in uses {
                    let at = *places.entry(edge.edge).or_insert(order.len());
                    match order.get_mut(at) {
                        None => order.push((edge.edge, shell.units, face.surface, whole)),
                        Some((.., known)) => *known = whole.max(*known),
                    }
                }
            }
        }
        let uses = stated.iter().flatten().flat_map(|face| &face.bounds);
        let uses: usize = uses.map(|bound| bound.uses().len()).sum();
        let bytes = order.len().saturating_mul(BYTES_PER_EDGE) + uses.saturating_mul(BYTES_PER_USE);
        if !self.table.budget.spend(bytes) {
            return EdgeDrafts::default();
        }
        let shared = self.shared_carriers(&order);
        let edge = |(key, units, surface, whole)| self.edge(key, units, surface, whole, &shared);
        EdgeDrafts { places, drafts: self.call.each(32, order, edge) }
    }

    /// Reads the curves that several edges share.
    fn shared_carriers(&self, edges: &[(EdgeKey, Units, u64, Whole)]) -> Carriers {
        let mut uses: Map<u64, (Units, usize)> = Map::default();
        for (key, units, ..) in edges.iter().take_while(|_| !self.call.is_cancelled()) {
            let EdgeKey::Curve(id) = key else { continue };
            let Ok((curve, _)) = self.geometry(*units).edge_curve(*id) else { continue };
            uses.entry(curve).or_insert((*units, 0)).1 += 1;
        }
        let shared = uses.into_iter().filter(|(_, (_, count))| *count > 1).collect::<Vec<_>>();
        let read = |(curve, (units, _)): (u64, (Units, usize))| {
            let carrier = self.geometry(units).carrier(curve, 0).ok()?;
            Some((curve, (units, carrier)))
        };
        self.call.each(32, shared, read).into_iter().flatten().collect()
    }

    fn edge(&self, key: EdgeKey, units: Units, surface: u64, whole: Whole, shared: &Carriers) -> Read<EdgeDraft> {
        let geometry = self.geometry(units);
        let (entity, ends, at, curve) = match key {
            EdgeKey::Curve(id) => return self.curved_edge(id, units, whole, shared),
            EdgeKey::Side(a, b) => {
                let at = Ends { start: geometry.point(a)?, end: geometry.point(b)?, whole: Whole::Never };
                (0, [a, b].map(VertexKey::Point), at, straight(at))
            }
            EdgeKey::Segment(id) => {
                let count = |points| self.count(Net::Curve, points, id);
                count(0)?;
                let (at, curve) = geometry.segment(id, surface)?;
                count(curve.curve.points.len())?;
                (id, [VertexKey::End(id, false), VertexKey::End(id, true)], at, Some(curve))
            }
        };
        EdgeDraft::new(entity, ends, at, curve, units)
    }

    /// Reads an edge along a curve. If the curve cannot be read, the edge becomes straight, so that its loops and faces
    /// stay closed. One between vertices in one place is refused, unless its curve has no other points.
    fn curved_edge(&self, id: u64, units: Units, whole: Whole, shared: &Carriers) -> Read<EdgeDraft> {
        let geometry = self.geometry(units);
        let (ends, at) = geometry.edge_ends(id, whole)?;
        let ends = ends.map(VertexKey::Point);
        let count = |points| self.count(Net::Curve, points, id);
        let read = || {
            let (curve, same) = geometry.edge_curve(id)?;
            count(0)?;
            let carrier = match shared.get(&curve) {
                Some((of, carrier)) if *of == units => carrier.clone(),
                _ => geometry.carrier(curve, 0)?,
            };
            let along = geometry.along(carrier, at, same, curve)?;
            count(along.as_ref().map_or(0, |bounded| bounded.curve.points.len()))?;
            EdgeDraft::new(id, ends, at, along, units)
        };
        read().or_else(|trouble| {
            let together = at.start.distance(at.end) <= units.tolerance;
            let closes = !trouble.is_point() && !geometry.is_straight(EdgeKey::Curve(id));
            if (together && closes) || self.call.is_cancelled() {
                return Err(trouble);
            }
            let cause = trouble.seen_from(id);
            // If the straight edge fails, too, report why the curve failed.
            let straight = EdgeDraft::new(id, ends, at, straight(at), units).map_err(|_| trouble)?;
            Ok(EdgeDraft { straightened: straight.curve.is_some().then_some(cause), ..straight })
        })
    }

    /// Swaps the vertices of an edge that the file states in the wrong order. On a closed curve that gives the other
    /// arc; on an open one it gives the same edge, hence `None`.
    fn exchanged(&self, id: u64, draft: &EdgeDraft) -> Option<EdgeDraft> {
        let geometry = self.geometry(draft.units);
        let (curve, same) = geometry.edge_curve(id).ok()?;
        if !geometry.is_closed(curve) {
            return None;
        }
        let ([end, start], [b, a]) = (draft.points, draft.ends);
        let at = Ends { start, end, whole: Whole::Never };
        let curve = geometry.between_ends(curve, at, same).ok()?;
        EdgeDraft::new(id, [a, b], at, curve, draft.units).ok()
    }
}

/// Memory of a face, an edge and a use of an edge, bytes, while they are read and in the model, without control points.
const BYTES_PER_FACE: usize = 600;
const BYTES_PER_EDGE: usize = 700;
const BYTES_PER_USE: usize = 160;

/// A curve that misses its vertices by more than this share of the part's size is pulled onto them.
const PULLED: f64 = 3e-5;

/// Edges miss their vertices by up to this share of the part's size where programs round: they state a tolerance of
/// 1e-7 for parts of any size.
const ROUNDED: f64 = 1e-6;

/// A part under construction.
struct Assembly<'a> {
    /// Loops over rows end early once it is cancelled. The part is then discarded.
    call: Call<'a>,
    part: Part,
    /// Diagonal of the box of all curves' control points.
    size: f64,
    edges: EdgeDrafts,
    corners: Corners,
    vertex_ids: Map<usize, VertexId>,
    diagnostics: Vec<Diagnostic>,
    /// Number of edges that miss their vertices by more than [`Units::corner`] but are not pulled, and the worst.
    gaps: Option<(usize, OffVertex)>,
}

/// An edge that misses its vertex.
struct OffVertex {
    gap: f64,
    entity: u64,
    /// The first face that uses it.
    face: FaceId,
    place: Option<DVec3>,
}

impl<'a> Assembly<'a> {
    fn new(
        call: Call<'a>,
        name: String,
        uses: &[ShellUse],
        shells: Vec<Shell>,
        colour: Option<Colour>,
        mut edges: EdgeDrafts,
    ) -> Self {
        let tolerance = uses.iter().map(|shell| shell.units.tolerance).fold(0.0, f64::max);
        let size = edges.size(call);
        edges.empty_points(size, call);
        // A part moves when it grows: ten milliseconds for the largest, where memory is cleared meanwhile.
        let most = edges.drafts.len();
        Self {
            call,
            part: Part { name, shells, colour, tolerance, edges: Vec::with_capacity(most), ..Part::default() },
            size,
            edges,
            corners: Corners::default(),
            vertex_ids: Map::default(),
            diagnostics: Vec::new(),
            gaps: None,
        }
    }

    fn say(&mut self, severity: Severity, entity: u64, place: Option<DVec3>, what: StepOutcome) {
        self.diagnostics.push(Diagnostic { entity, place, ..Diagnostic::new(severity, what) });
    }

    /// Reports something about the next face.
    fn say_of_face(&mut self, severity: Severity, entity: u64, place: Option<DVec3>, what: StepOutcome) {
        let face = Some(FaceId::new(self.part.faces.len()));
        self.diagnostics.push(Diagnostic { face, entity, place, ..Diagnostic::new(severity, what) });
    }

    /// Reports something about the next edge, which the next face uses.
    fn say_of_edge(&mut self, severity: Severity, entity: u64, place: Option<DVec3>, what: StepOutcome) {
        let (face, edge) = (Some(FaceId::new(self.part.faces.len())), Some(EdgeId::new(self.part.edges.len())));
        self.diagnostics.push(Diagnostic { face, edge, entity, place, ..Diagnostic::new(severity, what) });
    }

    /// Reports why the next face is lost.
    fn lose(&mut self, geometry: &Geometry<'_>, source: Source, trouble: &Trouble) {
        let what = StepOutcome::FaceLeftOut(trouble.seen_from(source.id()));
        self.say_of_face(Severity::Error, source.id(), geometry.place_near(source.id()), what);
    }

    /// Merges the corners at which neighbours in the loops of a face meet. Runs for all faces before any is built.
    fn meet(&mut self, face: &StatedFace) {
        for uses in face.bounds.iter().map(Bound::uses) {
            let mut ends = Vec::with_capacity(uses.len());
            for edge in uses {
                let Some(Ok(draft)) = self.edges.get_mut(edge.edge) else { continue };
                let (tail, head) = self.corners.ends(draft, edge.reversed);
                // A curve that closes is a loop by itself, however far its two vertices are apart.
                let [first, last] = draft.tips;
                let closes = uses.len() == 1 && first.distance(last) <= draft.units.corner();
                if draft.empty || closes {
                    self.corners.unite(tail, head);
                }
                ends.push((tail, head, draft.units.corner()));
            }
            for (i, (tail, head, corner)) in ends.iter().enumerate() {
                let (next_tail, next_head, _) = ends[(i + 1) % ends.len()];
                // As stated, else with either of the two edges, or both, reversed.
                let ways = [(*head, next_tail), (*head, next_head), (*tail, next_tail), (*tail, next_head)];
                let near =
                    |(a, b): &(usize, usize)| self.corners.points[*a].distance(self.corners.points[*b]) <= *corner;
                if let Some((a, b)) = ways.into_iter().find(near) {
                    self.corners.unite(a, b);
                }
            }
        }
    }

    /// The `EDGE_CURVE`s that every loop uses against its own direction. Ignores loops that close either way, such as
    /// two edges between the same two vertices.
    fn run_against(&mut self, stated: &[Read<StatedFace>]) -> Vec<u64> {
        let mut directed: Vec<(EdgeKey, bool)> = Vec::new();
        let call = self.call;
        let faces = stated.iter().take_while(|_| !call.is_cancelled());
        for uses in faces.flatten().flat_map(|face| &face.bounds).map(Bound::uses) {
            let mut keys = Vec::with_capacity(uses.len());
            let mut ends = Vec::with_capacity(uses.len());
            for edge in uses {
                let Some(Ok(draft)) = self.edges.get_mut(edge.edge) else { continue };
                if !draft.empty {
                    ends.push(self.corners.ends(draft, edge.reversed));
                    keys.push(edge.edge);
                }
            }
            let ways = [false, true].map(|first| head_to_tail(&ends, first));
            let ([Some(turned), None] | [None, Some(turned)]) = ways else { continue };
            directed.extend(keys.into_iter().zip(turned));
        }
        let against = |edge: &_| if let (EdgeKey::Curve(id), true) = edge { Some(*id) } else { None };
        let mut against: Vec<u64> = directed.iter().filter_map(against).collect();
        if against.is_empty() {
            return against;
        }
        let with: Set<EdgeKey> = directed.iter().filter(|(_, turned)| !turned).map(|(key, _)| *key).collect();
        against.sort_unstable();
        against.dedup();
        against.retain(|id| !with.contains(&EdgeKey::Curve(*id)));
        against
    }

    /// Moves vertices that belong to one closed edge alone onto the edge's curve. Nothing else meets there.
    fn settle_closed(&mut self, stated: &[Read<StatedFace>]) {
        let mut uses: Map<usize, usize> = Map::default();
        let call = self.call;
        let goes_on = || !call.is_cancelled();
        for draft in self.edges.drafts.iter_mut().take_while(|_| goes_on()).flatten().filter(|draft| !draft.empty) {
            let (start, end) = self.corners.ends(draft, false);
            *uses.entry(start).or_default() += 1;
            *uses.entry(end).or_default() += usize::from(start != end);
        }
        let bounds = stated.iter().flatten().flat_map(|face| &face.bounds);
        let lone = bounds.filter_map(|bound| if let Bound::Vertex(id) = bound { Some(*id) } else { None });
        let lone = lone.filter_map(|id| self.corners.find(VertexKey::Point(id))).collect::<Vec<_>>();
        for corner in lone {
            *uses.entry(corner).or_default() += 1;
        }
        for draft in self.edges.drafts.iter_mut().take_while(|_| goes_on()).flatten() {
            let (start, end) = self.corners.ends(draft, false);
            let [first, last] = draft.tips;
            if !draft.empty
                && start == end
                && uses.get(&start) == Some(&1)
                && first.distance(last) <= draft.units.tolerance
            {
                // Two vertices may have become this corner.
                draft.moved = draft.points.iter().map(|vertex| first.distance(*vertex)).fold(0.0, f64::max);
                draft.gap = first.distance(last);
                self.corners.points[start] = first;
            }
        }
    }

    /// The coedges of a loop, reversed where that makes them run head to tail, without edges of no length.
    fn chain(&mut self, uses: Vec<StatedUse>, face: u64) -> Read<Vec<StatedUse>> {
        let mut chain = Vec::with_capacity(uses.len());
        let mut ends = Vec::with_capacity(uses.len());
        for edge in uses {
            match self.edges.get_mut(edge.edge) {
                Some(Ok(draft)) if !draft.empty => {
                    ends.push(self.corners.ends(draft, edge.reversed));
                    chain.push(edge);
                }
                Some(Ok(_)) => {}
                Some(Err(trouble)) => return Err(trouble.clone()),
                None => return Err(Trouble::new(face, StepTrouble::Unread { what: "an edge of the face" })),
            }
        }
        // Some writers get the senses of edges wrong. The right ones follow from the first edge, as stated or reversed.
        // An open loop has none; prepare closes and reports it.
        if let Some(turned) = [false, true].into_iter().find_map(|first| head_to_tail(&ends, first)) {
            for (edge, turned) in chain.iter_mut().zip(&turned) {
                edge.reversed ^= turned;
            }
            if turned.contains(&true) {
                let place = ends.first().map(|(corner, _)| self.corners.points[*corner]);
                self.say(Severity::Warning, face, place, StepOutcome::EdgesTurned);
            }
        }
        Ok(chain)
    }

    /// Adds the edges of a face. Returns its surface, or why it has none, its loops, and whether the face is reversed
    /// against its surface.
    fn face(
        &mut self,
        geometry: &Geometry<'_>,
        stated: StatedFace,
        surface: Read<Stated>,
        source: Source,
    ) -> Read<(Result<Surface, StepCause>, Vec<Loop>, bool)> {
        // Loops that will be filled in space keep the orientation of the face.
        let same = surface.as_ref().map_or(true, |surface| stated.same_sense != surface.turned);
        let ends =
            |surface: &Stated| surface.surface.natural_domain().iter().all(|(a, b)| a.is_finite() && b.is_finite());
        if stated.bounds.is_empty() && !ends(surface.as_ref().map_err(Clone::clone)?) {
            return Err(Trouble::new(stated.surface, StepTrouble::Unbounded));
        }
        // Everything that can fail comes before changes to the part, so that a lost face leaves nothing behind.
        let mut chains = Vec::with_capacity(stated.bounds.len());
        let mut lost = stated.lost;
        for (k, mut bound) in stated.bounds.into_iter().enumerate() {
            if !same {
                bound.reverse();
            }
            let read = match bound {
                Bound::Edges(uses) => self.chain(uses, source.id()).map(ReadBound::Edges),
                Bound::Vertex(id) => geometry.vertex(id).map(|point| ReadBound::Vertex(VertexKey::Point(id), point)),
            };
            match read {
                Ok(chain) => chains.push(chain),
                Err(trouble) if stated.outer.is_some_and(|outer| outer != k) => lost.push(trouble),
                Err(trouble) => return Err(trouble),
            }
        }
        let empty = |chain: &ReadBound| matches!(chain, ReadBound::Edges(uses) if uses.is_empty());
        if let Err(trouble) = &surface
            && chains.iter().all(|chain| empty(chain) || matches!(chain, ReadBound::Vertex(..)))
        {
            return Err(trouble.clone());
        }
        if !chains.is_empty() && chains.iter().all(empty) {
            return Err(Trouble::new(source.id(), missing("bounds", "length")));
        }
        if stated.again > 0 {
            let what = StepOutcome::EdgesAgain { uses: stated.again };
            self.say_of_face(Severity::Note, source.id(), None, what);
        }
        for Trouble { entity, what } in lost {
            let place = geometry.place_near(entity).or_else(|| geometry.place_near(source.id()));
            let what = StepOutcome::LoopLeftOut(StepCause { entity: Some(entity), trouble: what });
            self.say_of_face(Severity::Error, source.id(), place, what);
        }
        let mut loops = Vec::with_capacity(chains.len());
        for chain in chains {
            match chain {
                ReadBound::Vertex(key, point) => {
                    let corner = self.corners.of(key, point);
                    loops.push(Loop::Vertex(self.vertex(corner)));
                }
                ReadBound::Edges(uses) if uses.is_empty() => {
                    self.say_of_face(Severity::Note, source.id(), None, StepOutcome::LoopWithoutLength);
                }
                ReadBound::Edges(uses) => loops.push(Loop::Edges(self.coedges(uses))),
            }
        }
        let surface = match surface {
            Ok(Stated { surface, note, .. }) => {
                if let Some((severity, what)) = note {
                    let place = geometry.place_near(source.id());
                    self.say_of_face(severity, source.id(), place, what);
                }
                Ok(surface)
            }
            Err(trouble) => Err(trouble.seen_from(source.id())),
        };
        Ok((surface, loops, !same))
    }

    fn coedges(&mut self, uses: Vec<StatedUse>) -> Vec<Coedge> {
        let coedge = |edge: StatedUse| Some(Coedge { edge: self.edge(edge.edge)?, reversed: edge.reversed });
        uses.into_iter().filter_map(coedge).collect()
    }

    /// Moves an edge into the part, once. `None` for an edge that was not read, which `chain` refuses before.
    fn edge(&mut self, key: EdgeKey) -> Option<EdgeId> {
        let draft = self.edges.get_mut(key)?.as_mut().ok()?;
        if draft.id.is_some() {
            return draft.id;
        }
        let BoundedCurve { mut curve, mut range, kind } = draft.curve.take()?;
        let id = EdgeId::new(self.part.edges.len());
        draft.id = Some(id);
        let straightened = draft.straightened.take();
        let EdgeDraft { entity, gap, moved, tips, units, .. } = *draft;
        let near = units.corner();
        let (start, end) = self.corners.ends(draft, false);
        let ends = [start, end].map(|corner| self.corners.points[corner]);
        let gap = gap.max(tips[0].distance(ends[0])).max(tips[1].distance(ends[1]));
        let off = tips.into_iter().zip(ends);
        let place = off.max_by(|(a, p), (b, q)| a.distance(*p).total_cmp(&b.distance(*q))).map(|(_, vertex)| vertex);
        if let Some(cause) = straightened {
            self.say_of_edge(Severity::Warning, entity, Some(ends[0]), StepOutcome::EdgeStraightened(cause));
        }
        if moved > near {
            self.say_of_edge(Severity::Note, entity, Some(ends[0]), StepOutcome::VertexMoved { gap_mm: moved });
        }
        if gap > PULLED * self.size {
            // Too far off for the mesh to bridge: move the end points of the curve, which bends its first and last
            // span.
            curve = spline::piece(&curve, range.0, range.1);
            range = curve.domain();
            if let [first, .., last] = curve.points.as_mut_slice() {
                [*first, *last] = ends;
            }
            let severity = if gap > near { Severity::Warning } else { Severity::Note };
            self.say_of_edge(severity, entity, place, StepOutcome::EdgePulled { gap_mm: gap });
        } else if gap > near {
            let (count, worst) = self.gaps.take().map_or((0, None), |(count, worst)| (count, Some(worst)));
            let here = OffVertex { gap, entity, face: FaceId::new(self.part.faces.len()), place };
            let worst = worst.filter(|worst| worst.gap >= gap).unwrap_or(here);
            self.gaps = Some((count + 1, worst));
        }
        let edge = Edge { curve, range, start: self.vertex(start), end: self.vertex(end), kind, entity };
        self.part.edges.push(edge);
        Some(id)
    }

    fn vertex(&mut self, corner: usize) -> VertexId {
        let corner = self.corners.root(corner);
        *self.vertex_ids.entry(corner).or_insert_with(|| {
            self.part.vertices.push(self.corners.points[corner]);
            VertexId::new(self.part.vertices.len() - 1)
        })
    }

    fn finish(mut self) -> (Part, Vec<Diagnostic>) {
        if let Some((count, OffVertex { gap, entity, face, place })) = self.gaps.take() {
            let what = StepOutcome::EdgesOffVertices { edges: count, gap_mm: gap };
            let severity = if gap > ROUNDED * self.size { Severity::Warning } else { Severity::Note };
            let told = Diagnostic { face: Some(face), entity, place, ..Diagnostic::new(severity, what) };
            self.diagnostics.push(told);
        }
        // Open loops cost no face; prepare reports them with width and place.
        if let Err(error) = self.part.check()
            && !matches!(error, PartError::OpenLoop { .. })
        {
            self.say(Severity::Error, 0, None, StepOutcome::PartUnsound(error));
        }
        (self.part, self.diagnostics)
    }
}

/// A checked bound.
enum ReadBound {
    Edges(Vec<StatedUse>),
    Vertex(VertexKey, DVec3),
}
