//! One face of a model -> the images of its loops, one after the other over the surface.

use crate::math::boxes::around;
use crate::model::{Coedge, EdgeId, Face, FaceError, FaceTrouble, Loop, Part, RegionError, Surface};
use crate::prepare::regions::trace::{Passages, trace_loop};
use crate::prepare::regions::unroll::are_holes;
use crate::prepare::report::Room;
use crate::prepare::surface::decompose::BezierSpline3;
use crate::prepare::trims::free_edges::FreeFace;
use crate::prepare::uv::projector::Projector;
use crate::prepare::uv::uv_loop::UvLoop;
use glam::DVec3;

/// A point of a face, for diagnostics: its first vertex, or the middle of an untrimmed surface. `None` if neither is
/// sound, or if the face is lost and has no vertex.
pub(crate) fn somewhere(part: &Part, face: &Face) -> Option<DVec3> {
    let vertex = boundary_points(part, face).find(|p| p.is_finite());
    vertex.or_else(|| {
        if face.lost || face.surface.check().is_err() {
            return None;
        }
        let middle = face.surface.natural_domain().map(|(a, b)| 0.5 * (a + b));
        let point = middle.iter().all(|x| x.is_finite()).then(|| face.surface.point(middle[0], middle[1]));
        point.filter(|p| p.is_finite())
    })
}

/// Maximum distance of edges from their face's surface, as a share of the face's size. The image of an edge further
/// away is noise: it bounds nothing, and resolving its crossings can take minutes. A nearer edge is projected along the
/// normals.
const LOST_SHARE: f64 = 0.25;

/// A face with the images of its loops. Every way to prepare the face starts from here.
pub(super) struct Traced<'a> {
    pub(super) part: &'a Part,
    pub(super) face: &'a Face,
    pub(super) free: Option<&'a Result<FreeFace, FaceError>>,
    /// Memory that the face may take.
    pub(super) room: &'a Room,
    pub(super) projector: Projector<'a>,
    pub(super) passages: Passages,
    /// Size of the face.
    pub(super) extent: f64,
    pub(super) loops: Vec<UvLoop>,
    /// The pole at which the file puts a vertex loop.
    pub(super) named_pole: Option<usize>,
    /// Largest distance between edges and surface.
    pub(super) gap: f64,
    pub(super) notes: Vec<FaceTrouble>,
}

impl<'a> Traced<'a> {
    /// `free` is the outcome of the face's free trims, if it has any. A face without edges has size `size`.
    pub(super) fn of(
        part: &'a Part,
        face: &'a Face,
        free: Option<&'a Result<FreeFace, FaceError>>,
        size: f64,
        room: &'a Room,
    ) -> Result<Self, FaceError> {
        if let Some(cause) = &face.refused {
            return Err(FaceError::Refused(cause.clone()));
        }
        // The fields of models are public, and NaN passes every comparison below.
        face.surface.check().map_err(FaceError::Surface)?;
        if !boundary_points(part, face).all(DVec3::is_finite) {
            return Err(RegionError::NotFinite.into());
        }
        let extent = face_extent(part, face).unwrap_or(size);
        let mut projector = Projector::new(&face.surface, 1e-6 * extent);
        let mut passages = Passages::new();
        if !projector.poles.is_empty() {
            let uses = |edge: EdgeId| face.wires().flatten().filter(|c| c.edge == edge).count();
            for c in face.wires().flatten() {
                projector.keep_off_poles(&part.edges[c.edge.index()], || uses(c.edge) > 1);
            }
            passages = self::passages(part, face, &projector);
            projector.adopt(boundary_points(part, face), part.tolerance);
        }
        if let Some(Ok(free)) = free {
            let edges = free.region.edges().map(|edge| &part.edges[edge as usize]);
            projector.adopt(edges.flat_map(|e| [e.start, e.end]).map(|v| part.vertices[v.index()]), 0.0);
        }
        projector.adopt(passages.values().flatten().map(|p| p.1), 0.0);
        for (_, point) in passages.values_mut().flatten() {
            *point = projector.pole_at(*point).map_or(*point, |pole| projector.poles[pole].point);
        }
        let loops = Vec::with_capacity(face.loops.len());
        let mut out = Self {
            part,
            face,
            free,
            room,
            projector,
            passages,
            extent,
            loops,
            named_pole: None,
            gap: 0.0,
            notes: Vec::new(),
        };
        out.trace()?;
        if are_holes(&out.loops, &out.projector) {
            // The holes may be far smaller than the face.
            out.extent = out.extent.max(surface_extent(&face.surface));
        }
        Ok(out)
    }

    fn trace(&mut self) -> Result<(), FaceError> {
        let part = self.part;
        for l in &self.face.loops {
            match l {
                Loop::Edges(coedges) => {
                    let (traced, miss) = trace_loop(part, coedges, &self.projector, &mut self.gap, &self.passages)?;
                    self.loops.push(traced);
                    self.notes.extend(miss.map(|gap_mm| FaceTrouble::LoopMissesStart { gap_mm }));
                }
                Loop::Vertex(v) => self.named_pole = self.projector.only_pole_at(part.vertices[v.index()]),
            }
        }
        let near = self.gap <= LOST_SHARE * self.extent;
        if !near {
            return Err(FaceError::OffSurface { gap_mm: self.gap, extent_mm: self.extent });
        }
        Ok(())
    }
}

/// The B-rep vertices on a face's boundary.
fn boundary_points<'a>(part: &'a Part, face: &'a Face) -> impl Iterator<Item = DVec3> + 'a {
    face.loops.iter().flat_map(move |l| {
        let (coedges, single): (&[Coedge], _) = match l {
            Loop::Edges(coedges) => (coedges, None),
            Loop::Vertex(v) => (&[], Some(*v)),
        };
        let ends = |c: &Coedge| part.edges.get(c.edge.index()).map(|e| [e.start, e.end]);
        let vertices = coedges.iter().filter_map(ends).flatten().chain(single);
        vertices.filter_map(|v| part.vertices.get(v.index()).copied())
    })
}

/// The parameters and points at which edges of a face run through poles.
fn passages(part: &Part, face: &Face, projector: &Projector<'_>) -> Passages {
    let mut out = Passages::new();
    for c in face.wires().flatten() {
        let edge = &part.edges[c.edge.index()];
        let stops = projector.pole_passages(edge);
        if !stops.is_empty() {
            let curve = BezierSpline3::new(&edge.curve, edge.range);
            out.insert(c.edge.0, stops.into_iter().map(|t| (t, curve.point(t))).collect());
        }
    }
    out
}

/// Diagonal of the box of a surface that closes, by points of it.
fn surface_extent(surface: &Surface) -> f64 {
    let places = |(a, b): (f64, f64)| (0..=8).map(|k| a + (b - a) * f64::from(k) / 8.0).collect::<Vec<f64>>();
    let [us, vs] = surface.natural_domain().map(places);
    let [low, high] = around(surface.lattice(&us, &vs));
    (high - low).length()
}

/// Diagonal of the box of the face's edges. `None` for a face without edges.
pub(crate) fn face_extent(part: &Part, face: &Face) -> Option<f64> {
    let [low, high] = around(face.wires().flatten().flat_map(|c| &part.edges[c.edge.index()].curve.points).copied());
    let d = (high - low).length();
    (d.is_finite() && d > 0.0).then_some(d)
}
