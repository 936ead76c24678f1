//! Stated faces and their edges -> the surface of each face. Faces with a common surface share the result.
//!
//! Edges are placed by their curves in space. Only where sheets of a surface coincide does the shape not tell which one
//! the face is on; parameter curves that the file states do.

use super::budget::Net;
use super::contents::{ShellUse, Source};
use super::curve::{BoundedCurve, WRAPPERS};
use super::draft::EdgeDrafts;
use super::face_location::{FaceLocation, Stated};
use super::loops::{Bound, EdgeKey, StatedFace, StatedUse};
use super::options::StepOptions;
use super::place::Geometry;
use super::revolution::one_sheet;
use super::spline;
use super::style::Styles;
use super::table::{Read, Table, Trouble};
use super::units::Units;
use super::values::Map;
use crate::control::Call;
use crate::math::boxes::around;
use crate::model::{Colour, Frame3, Severity, StepOutcome, StepTrouble, Surface};
use glam::DVec3;
use std::cell::Cell;

/// Context shared by all parts of a file.
#[derive(Clone, Copy)]
pub(super) struct Reader<'a> {
    pub(super) call: Call<'a>,
    pub(super) table: &'a Table,
    pub(super) styles: &'a Styles,
    /// Colours for faces without one, from copies of them.
    pub(super) colours_of_copies: &'a Map<u64, Colour>,
    pub(super) options: &'a StepOptions,
}

impl Reader<'_> {
    /// The colour of a face, else that of a copy of it.
    pub(super) fn colour(&self, face: u64) -> Option<Colour> {
        self.styles.of(face).or_else(|| self.colours_of_copies.get(&face).copied())
    }

    /// Access to geometry in `units`.
    pub(super) fn geometry(&self, units: Units) -> Geometry<'_> {
        Geometry::new(self.table, units, self.options.fit_tolerance)
    }

    /// Adds control points of instance `id`, as [`ReadBudget::net`](super::budget::ReadBudget::net) does.
    pub(super) fn count(&self, net: Net, points: usize, id: u64) -> Read<()> {
        self.table.budget.net(net, points).map_err(|what| Trouble::new(id, what))
    }
}

/// Steps between points per parameter curve; its ends are left out.
const STEPS: usize = 8;

impl Geometry<'_> {
    /// Profile parameters of points on a face's boundary, as the parameter curves of its edges on its surface of
    /// revolution state them. Empty if the file has none that can be read.
    fn profile_parameters(&self, face: &StatedFace) -> Vec<f64> {
        let curves = face.bounds.iter().flat_map(Bound::uses).filter_map(|edge| match edge.edge {
            EdgeKey::Curve(id) => Some(self.edge_curve(id).ok()?.0),
            EdgeKey::Side(..) | EdgeKey::Segment(_) => None,
        });
        let mut stated = Vec::new();
        for pcurve in curves.flat_map(|curve| self.pcurves(curve)).filter_map(|id| self.get(id).ok()) {
            let on = pcurve.is("PCURVE").then(|| pcurve.fields("PCURVE", 1).reference(0));
            if !matches!(on, Some(Ok(surface)) if surface == face.surface) {
                continue;
            }
            let Ok((on, curve)) = self.parameter_curve(pcurve, "PCURVE", 0) else { continue };
            let (a, b) = curve.domain();
            let points = (1..STEPS).map(|i| curve.point(a + (b - a) * i as f64 / STEPS as f64));
            stated.extend(points.map(|p| on.natural(p.x, p.y)[1]));
        }
        stated
    }

    /// The parameter curves that are stated with a curve in space.
    fn pcurves(&self, curve: u64) -> Vec<u64> {
        let Ok(curve) = self.get(curve) else { return Vec::new() };
        let Some(kind) = curve.first_of(WRAPPERS) else { return Vec::new() };
        curve.fields(kind, 1).links(1).map_or_else(|_| Vec::new(), Iterator::collect)
    }
}

/// A face to read: its shell's index, the use of the shell, the face, and whether the use flips it.
pub(super) type FaceJob<'a> = (u32, &'a ShellUse, Source, bool);

/// Largest distance of bounds from their implied plane, as a share of the face's size: files print rounded digits.
const FLAT: f64 = 1e-6;

impl Reader<'_> {
    /// Reads the surfaces of faces; `None` for faces that were not read.
    pub(super) fn surfaces(
        &self,
        jobs: &[FaceJob<'_>],
        stated: &[Read<StatedFace>],
        edges: &EdgeDrafts,
    ) -> Vec<Option<Read<Stated>>> {
        let mut groups: Vec<Vec<usize>> = Vec::with_capacity(jobs.len());
        let mut known: Map<u64, usize> = Map::default();
        for (k, face) in stated.iter().enumerate() {
            let Ok(face) = face else { continue };
            let group = *known.entry(face.surface).or_insert(groups.len());
            match groups.get_mut(group) {
                None => groups.push(vec![k]),
                Some(group) => group.push(k),
            }
        }
        let groups: Vec<Vec<(usize, Read<Stated>)>> = self.call.each(16, groups, |group| {
            // A surface that does not depend on the place of the face is shared by all faces in the same units.
            let mut common: Option<(&ShellUse, Read<Stated>)> = None;
            let is_shared = group.len() > 1;
            let mut read = Vec::with_capacity(group.len());
            for k in group {
                let (Some(&(_, shell, source, _)), Some(Ok(face))) = (jobs.get(k), stated.get(k)) else { continue };
                let geometry = self.geometry(shell.units);
                let asked = Cell::new(false);
                let reach = || {
                    asked.set(true);
                    reach(&geometry, face, edges)
                };
                let count = |points| self.count(Net::Surface, points, face.surface);
                let surface = count(0).and_then(|()| match (&common, source) {
                    _ if face.implied => implied_plane(&geometry, face, edges),
                    (Some((of, surface)), Source::Face(_)) if of.units == shell.units => surface.clone(),
                    (_, Source::Face(id)) if id == face.surface => Err(geometry.no_surface(id)),
                    (_, Source::Face(_)) => geometry.surface(face.surface, &reach, 0),
                    (_, Source::Surface(id)) => geometry.whole_surface(id),
                });
                let surface = surface.and_then(|stated| count(points_of(&stated.surface)).map(|()| stated));
                if is_shared && matches!(source, Source::Face(_)) && !asked.get() && common.is_none() {
                    common = Some((shell, surface.clone()));
                }
                read.push((k, settled(&geometry, (face, edges), surface, || reach().on)));
            }
            read
        });
        let mut surfaces: Vec<Option<Read<Stated>>> = (0..jobs.len()).map(|_| None).collect();
        for (k, surface) in groups.into_iter().flatten() {
            if let Some(slot) = surfaces.get_mut(k) {
                *slot = Some(surface);
            }
        }
        surfaces
    }
}

/// Number of control points of a surface.
fn points_of(surface: &Surface) -> usize {
    match surface {
        Surface::Nurbs(net) => net.points.len(),
        Surface::Extrusion { curve, .. } | Surface::Revolution { curve, .. } => curve.points.len(),
        _ => 0,
    }
}

/// Reduces a surface to the sheet that contains the face, and checks it.
fn settled(
    geometry: &Geometry<'_>,
    (face, edges): (&StatedFace, &EdgeDrafts),
    surface: Read<Stated>,
    on: impl FnOnce() -> Vec<DVec3>,
) -> Read<Stated> {
    let is_outwards = |centre, to_pole| Some(is_outwards(face, edges, centre, to_pole)? == face.same_sense);
    let meets = |p| meets(face, edges, p);
    let stated = one_sheet(surface?, on, || geometry.profile_parameters(face), is_outwards, meets, face.same_sense);
    match stated.surface.check() {
        Ok(()) => Ok(stated),
        Err(error) => Err(Trouble::new(face.surface, error)),
    }
}

/// Whether an edge of a face comes to a point, as near as rounding explains. `None` for a face without edges.
fn meets(face: &StatedFace, edges: &EdgeDrafts, p: DVec3) -> Option<bool> {
    let uses = face.bounds.iter().flat_map(Bound::uses);
    let mut curves = uses.filter_map(|edge| edges.get(edge.edge)?.as_ref().ok()?.curve.as_ref()).peekable();
    curves.peek()?;
    Some(curves.any(|BoundedCurve { curve, range, .. }| {
        let [low, high] = around(curve.points.iter().copied());
        // The nearest point of a closed curve may be the end that the edge does not use.
        let nearest = spline::nearest(curve, p).clamp(range.0, range.1);
        let near = |t: f64| curve.point(t).distance(p) <= spline::ROUNDED * low.distance(high);
        [nearest, range.0, range.1].into_iter().any(near)
    }))
}

/// Points of the face's boundary.
fn reach(geometry: &Geometry<'_>, face: &StatedFace, edges: &EdgeDrafts) -> FaceLocation {
    let mut reached = FaceLocation::default();
    for bound in &face.bounds {
        match bound {
            Bound::Vertex(id) => {
                let vertex = geometry.vertex(*id).ok();
                reached.hull.extend(vertex);
                reached.on.extend(vertex);
            }
            Bound::Edges(uses) => {
                for draft in uses.iter().filter_map(|edge| edges.get(edge.edge)?.as_ref().ok()) {
                    reached.hull.extend(draft.curve.iter().flat_map(|bounded| &bounded.curve.points));
                    reached.on.extend(draft.samples());
                    if draft.empty {
                        reached.hull.push(draft.points[0]);
                        reached.on.push(draft.points[0]);
                    }
                }
            }
        }
    }
    reached
}

/// Points along the bounds of a face, in their directions.
fn rings(face: &StatedFace, edges: &EdgeDrafts) -> Read<Vec<Vec<DVec3>>> {
    let mut rings = Vec::new();
    for bound in &face.bounds {
        let Bound::Edges(uses) = bound else { continue };
        let mut ring = Vec::new();
        for edge in uses {
            let draft = match edges.get(edge.edge) {
                Some(Ok(draft)) => draft,
                Some(Err(trouble)) => return Err(trouble.clone()),
                None => continue,
            };
            let from = ring.len();
            ring.extend(draft.samples());
            if edge.reversed {
                ring[from..].reverse();
            }
        }
        rings.push(ring);
    }
    Ok(rings)
}

/// Twice the vector area of rings, seen from `origin`.
fn vector_area(rings: &[Vec<DVec3>], origin: DVec3) -> DVec3 {
    let of_ring = |ring: &Vec<DVec3>| {
        let next = ring.iter().cycle().skip(1);
        ring.iter().zip(next).map(|(p, q)| (*p - origin).cross(*q - origin)).sum::<DVec3>()
    };
    rings.iter().map(of_ring).sum()
}

/// Whether the normal of a face between two poles of a sphere leads away from the centre: its bound encloses less than
/// half of the sphere. `None` for other faces, and if it encloses half.
fn is_outwards(face: &StatedFace, edges: &EdgeDrafts, centre: DVec3, to_pole: DVec3) -> Option<bool> {
    let [Bound::Edges(uses)] = face.bounds.as_slice() else { return None };
    let rings = rings(face, edges).ok()?;
    let is_at = |p: DVec3| rings.iter().flatten().any(|q| q.distance(p) <= FLAT * to_pole.length());
    let has_slit = uses.iter().any(|use_| uses.contains(&StatedUse { reversed: !use_.reversed, ..*use_ }));
    if has_slit || !is_at(centre + to_pole) || !is_at(centre - to_pole) {
        return None;
    }
    let towards = vector_area(&rings, centre);
    let (mut side, mut most) = (0.0, 0.0);
    for out in rings.iter().flatten().map(|p| *p - centre) {
        (side, most) = (side + out.dot(towards), most + out.length() * towards.length());
    }
    (side.abs() > FLAT * most).then_some(side > 0.0)
}

/// The plane of the bounds of a face without surface. The bounds run counterclockwise about its normal.
fn implied_plane(geometry: &Geometry<'_>, face: &StatedFace, edges: &EdgeDrafts) -> Read<Stated> {
    let rings = rings(face, edges)?;
    let points = rings.concat();
    let origin = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let area = vector_area(&rings, origin);
    let size = points.iter().map(|p| p.distance(origin)).fold(0.0, f64::max);
    let along = points.first().map_or(DVec3::ZERO, |p| *p - origin);
    let frame = Some(area).filter(|area| area.length() > 1e-12 * size * size);
    let frame = frame.and_then(|area| Frame3::from_axis(origin, area, along));
    let Some(frame) = frame else {
        return Err(Trouble::new(face.surface, StepTrouble::NoPlane));
    };
    let off = points.iter().map(|p| frame.local(*p).z.abs()).fold(0.0, f64::max);
    let note = (off > geometry.units.tolerance.max(FLAT * size))
        .then_some((Severity::Warning, StepOutcome::ImpliedPlane { gap_mm: off }));
    Ok(Stated { surface: Surface::Plane { frame }, turned: false, note })
}
