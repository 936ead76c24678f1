//! Faces -> their bounds as stated in the file: edges in order, with directions.

use super::contents::Source;
use super::kinds::is_face;
use super::place::Geometry;
use super::table::{MAX_DEPTH, Read, Trouble, missing};
use super::units::{Ends, Whole};
use super::values::{Attribute, Set};
use crate::model::StepTrouble;
use foldhash::fast::RandomState;
use glam::DVec3;
use std::hash::Hash;

/// One use of an edge by a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct StatedUse {
    pub(super) edge: EdgeKey,
    pub(super) reversed: bool,
}

/// Identity of an edge: uses with equal keys share one edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum EdgeKey {
    /// An `EDGE_CURVE`, or a `SUBEDGE` of one.
    Curve(u64),
    /// A side of a `POLY_LOOP`: its two points, the lower number first.
    Side(u64, u64),
    /// A segment of a surface's boundary curve.
    Segment(u64),
}

/// Identity of a vertex: a `VERTEX_POINT`, a point of a `POLY_LOOP`, or one end of a boundary segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum VertexKey {
    Point(u64),
    /// Start (`false`) or end (`true`) of a boundary segment.
    End(u64, bool),
}

/// A bound of a face, as stated.
#[derive(Clone, Debug)]
pub(super) enum Bound {
    Edges(Vec<StatedUse>),
    Vertex(u64),
}

impl Bound {
    /// Its edges; none of a vertex.
    pub(super) fn uses(&self) -> &[StatedUse] {
        match self {
            Self::Edges(uses) => uses,
            Self::Vertex(_) => &[],
        }
    }

    pub(super) fn reverse(&mut self) {
        if let Self::Edges(uses) = self {
            uses.reverse();
            for edge in uses {
                edge.reversed = !edge.reversed;
            }
        }
    }
}

/// A face before its surface and edges are read.
#[derive(Clone, Debug)]
pub(super) struct StatedFace {
    pub(super) surface: u64,
    /// Whether the face has no surface and lies in the plane of its bounds. `surface` is the face itself then, and also
    /// if a required surface is missing.
    pub(super) implied: bool,
    pub(super) same_sense: bool,
    /// Bounds, counterclockwise seen from the tip of the *face's* normal.
    pub(super) bounds: Vec<Bound>,
    /// Index of the outer bound. If it fails, the face is lost. `None` if every bound is required.
    pub(super) outer: Option<usize>,
    /// Inner bounds that could not be read.
    pub(super) lost: Vec<Trouble>,
    /// How many uses of edges the bounds list again. They are left out.
    pub(super) again: usize,
}

impl Geometry<'_> {
    pub(super) fn stated_face(&self, source: Source) -> Read<StatedFace> {
        match source {
            Source::Face(id) => {
                let face = self.get(id)?;
                if face.is("ORIENTED_FACE") {
                    return Err(Trouble::new(id, StepTrouble::TooDeep { what: "oriented faces" }));
                }
                if !is_face(face) {
                    return Err(face.not_read("faces"));
                }
                let own = face.fields("FACE_SURFACE", 2);
                let plain = !(face.is("FACE_SURFACE") || face.is("ADVANCED_FACE"));
                let implied = plain || own.any(0).is_some_and(Attribute::is_implied);
                // A complex instance keeps the bounds in FACE.
                let stated: Vec<u64> = face.fields("FACE", 1).links(0)?.collect();
                let is_outer = |id: &u64| self.get(*id).is_ok_and(|bound| bound.is("FACE_OUTER_BOUND"));
                // If no bound is marked as outer, the first usually is.
                let first = stated.iter().position(is_outer).unwrap_or(0);
                let (mut bounds, mut outer, mut lost) = (Vec::with_capacity(stated.len()), None, Vec::new());
                let mut again = 0;
                for (k, id) in stated.into_iter().enumerate() {
                    match self.bound(id) {
                        Ok((bound, repeats)) => {
                            again += repeats;
                            if k == first {
                                outer = Some(bounds.len());
                            }
                            bounds.push(bound);
                        }
                        Err(trouble) if k == first => return Err(trouble),
                        Err(trouble) => lost.push(trouble),
                    }
                }
                let surface = if implied { id } else { own.reference(0).unwrap_or(id) };
                // The bounds of a face without surface determine its orientation.
                let same_sense = implied || own.flag(1, true);
                Ok(StatedFace { surface, implied, same_sense, bounds, outer, lost, again })
            }
            Source::Surface(id) => {
                let surface = self.get(id)?;
                let (mut bounds, mut again) = (Vec::new(), 0);
                if surface.is("CURVE_BOUNDED_SURFACE") {
                    let own = surface.fields("CURVE_BOUNDED_SURFACE", 1);
                    // The sides of the surface bound it, and these are holes.
                    if own.flag(2, false) {
                        return Err(surface.not_read("implicit outer bounds"));
                    }
                    for boundary in own.links(1)? {
                        let segments = self.get(boundary)?.fields("COMPOSITE_CURVE", 1).links(0)?;
                        let (segments, repeats) = unique(segments);
                        again += repeats;
                        bounds.push(Bound::Edges(segments.map(|id| self.segment_use(id)).collect::<Read<_>>()?));
                    }
                }
                let (outer, lost) = (None, Vec::new());
                Ok(StatedFace { surface: id, implied: false, same_sense: true, bounds, outer, lost, again })
            }
        }
    }

    /// Why face `id` has no surface, although its type requires one.
    pub(super) fn no_surface(&self, id: u64) -> Trouble {
        let stated = self.get(id).and_then(|face| face.fields("FACE_SURFACE", 2).reference(0));
        stated.err().unwrap_or_else(|| Trouble::new(id, StepTrouble::RefersToItself { what: "a face as surface" }))
    }

    fn segment_use(&self, id: u64) -> Read<StatedUse> {
        let same = self.get(id)?.fields("COMPOSITE_CURVE_SEGMENT", 0).flag(1, true);
        Ok(StatedUse { edge: EdgeKey::Segment(id), reversed: !same })
    }

    /// A bound, and how many uses of edges it lists again.
    fn bound(&self, id: u64) -> Read<(Bound, usize)> {
        let fields = self.get(id)?.fields("FACE_BOUND", 1);
        let of = self.get(fields.reference(0)?)?;
        let (mut bound, again) = if of.is("EDGE_LOOP") {
            // A complex instance has the list in PATH.
            let list = ["EDGE_LOOP", "PATH"].into_iter().find_map(|name| of.fields(name, 1).links(0).ok());
            let list = list.ok_or_else(|| Trouble::new(of.id, missing("an EDGE_LOOP", "a list of edges")))?;
            let (list, again) = unique(list);
            (Bound::Edges(list.map(|edge| self.oriented_edge(edge)).collect::<Read<_>>()?), again)
        } else if of.is("VERTEX_LOOP") {
            (Bound::Vertex(of.fields("VERTEX_LOOP", 1).reference(0)?), 0)
        } else if of.is("POLY_LOOP") {
            let points: Vec<u64> = of.fields("POLY_LOOP", 1).links(0)?.collect();
            let (sides, again) = unique(sides(&points));
            (Bound::Edges(sides.collect()), again)
        } else {
            return Err(of.not_read("bounds"));
        };
        if let Bound::Edges(uses) = &bound
            && uses.is_empty()
        {
            return Err(Trouble::new(of.id, missing("a loop", "edges")));
        }
        if !fields.flag(1, true) {
            bound.reverse();
        }
        Ok((bound, again))
    }

    /// When the edges of a loop cover a whole closed curve.
    pub(super) fn whole(&self, uses: &[StatedUse]) -> Whole {
        let edges: Set<EdgeKey> = uses.iter().map(|edge| edge.edge).collect();
        match uses {
            [_] => Whole::Alone,
            _ if edges.len() < uses.len() => Whole::BesideSeam,
            // A short arc and the line between its ends would enclose nothing.
            [a, b] if self.is_straight(a.edge) || self.is_straight(b.edge) => Whole::BesideLine,
            _ => Whole::Never,
        }
    }

    /// Whether an edge lies on a line, which cannot close it.
    pub(super) fn is_straight(&self, key: EdgeKey) -> bool {
        let EdgeKey::Curve(id) = key else { return false };
        self.edge_curve(id).and_then(|(curve, _)| self.unwrap(curve, 0)).is_ok_and(|curve| curve.is("LINE"))
    }

    fn oriented_edge(&self, id: u64) -> Read<StatedUse> {
        let (mut edge, mut reversed) = (self.get(id)?, false);
        for _ in 0..MAX_DEPTH {
            // An edge without a curve becomes straight, with a diagnostic.
            if edge.is_any(["EDGE_CURVE", "SUBEDGE", "EDGE"]) {
                return Ok(StatedUse { edge: EdgeKey::Curve(edge.id), reversed });
            }
            // A seam edge only selects one of the seam's two parameter curves.
            if !(edge.is("ORIENTED_EDGE") || edge.is("SEAM_EDGE")) {
                return Err(edge.not_read("edges"));
            }
            // name, (start, end, derived), edge, orientation
            let own = edge.fields("ORIENTED_EDGE", 3);
            reversed ^= !own.flag(1, true);
            edge = self.get(own.reference(0)?)?;
        }
        Err(Trouble::new(id, StepTrouble::TooDeep { what: "oriented edges" }))
    }

    /// The curve of an edge, and whether the edge has the curve's direction. A `SUBEDGE` has those of its parent.
    pub(super) fn edge_curve(&self, id: u64) -> Read<(u64, bool)> {
        let (mut edge, mut same) = (self.get(id)?, true);
        for _ in 0..MAX_DEPTH {
            edge = if edge.is("EDGE_CURVE") {
                let own = edge.fields("EDGE_CURVE", 3);
                return Ok((own.reference(0)?, own.flag(1, true) == same));
            } else if edge.is("SUBEDGE") {
                self.get(edge.fields("SUBEDGE", 3).reference(0)?)?
            } else if edge.is("ORIENTED_EDGE") || edge.is("SEAM_EDGE") {
                let own = edge.fields("ORIENTED_EDGE", 3);
                same ^= !own.flag(1, true);
                self.get(own.reference(0)?)?
            } else {
                return Err(edge.not_read("edges"));
            };
        }
        Err(Trouble::new(id, StepTrouble::TooDeep { what: "subedges" }))
    }

    /// The point of a vertex instance.
    pub(super) fn vertex(&self, id: u64) -> Read<DVec3> {
        let vertex = self.get(id)?;
        if vertex.is("VERTEX_POINT") {
            return self.point(vertex.fields("VERTEX_POINT", 1).reference(0)?);
        }
        self.point(id)
    }

    /// The vertices of an `EDGE_CURVE` or `SUBEDGE`, and their points. `whole` comes from the loops.
    pub(super) fn edge_ends(&self, id: u64, whole: Whole) -> Read<([u64; 2], Ends)> {
        let own = self.get(id)?.fields("EDGE", 1);
        let (from, to) = (own.reference(0)?, own.reference(1)?);
        let whole = if from == to { Whole::OneVertex } else { whole };
        Ok(([from, to], Ends { start: self.vertex(from)?, end: self.vertex(to)?, whole }))
    }
}

/// The first of each of the items that are equal, in order, and how many others there are. ISO 10303-42 allows none in
/// a path: each would be a way around the face, paid for as often as it is listed.
fn unique<T: Copy + Eq + Hash>(items: impl Iterator<Item = T>) -> (impl Iterator<Item = T>, usize) {
    let mut all: Vec<T> = items.collect();
    let (listed, mut seen) = (all.len(), Set::with_capacity_and_hasher(all.len(), RandomState::default()));
    all.retain(|item| seen.insert(*item));
    let again = listed - all.len();
    (all.into_iter(), again)
}

/// The sides of a polygon, without those between equal points.
fn sides(points: &[u64]) -> impl Iterator<Item = StatedUse> {
    let next = points.iter().cycle().skip(1);
    let apart = points.iter().zip(next).filter(|(a, b)| a != b);
    apart.map(|(a, b)| StatedUse { edge: EdgeKey::Side(*a.min(b), *a.max(b)), reversed: a > b })
}
