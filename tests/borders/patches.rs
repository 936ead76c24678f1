//! Hand-made patches, prepared and meshed.

use crate::common::whole_frame;
use glam::{DVec2, DVec3};
use std::sync::Arc;
use trimtess::frame::{Tolerance, plan};
use trimtess::mesh::{MemorySink, MeshFacts, check_scene};
use trimtess::model::{
    Frame3, FreeTrims, Loop, Model, NurbsCurve3, NurbsSurface, Part, PartBuilder, Severity, ShellKind, Surface,
};
use trimtess::prepare::internals::OpenEdges;
use trimtess::prepare::{PrepareOptions, Prepared, prepare};

/// A Bézier patch with these rows of control points along v.
pub(crate) fn patch(rows: &[Vec<DVec3>]) -> NurbsSurface {
    NurbsSurface::bezier((rows.len() - 1, rows[0].len() - 1), rows.concat(), Vec::new())
}

/// A smooth height over the plane.
pub(crate) fn height(p: DVec2) -> f64 {
    (1.3 * p.x + 0.4).sin() + (0.9 * p.y - 0.2).cos() + 0.3 * p.x * p.y
}

/// The bicubic patch over a rectangle, with control points at [`height`] above an even lattice. Adjacent patches have
/// equal control points on their common border.
pub(crate) fn bicubic(low: DVec2, high: DVec2) -> NurbsSurface {
    let at = |i: usize, j: usize| {
        let p = low + (high - low) * DVec2::new(i as f64, j as f64) / 3.0;
        p.extend(height(p))
    };
    patch(&[0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| at(i, j)).to_vec()))
}

pub(crate) fn left() -> NurbsSurface {
    bicubic(DVec2::ZERO, DVec2::new(3.0, 3.0))
}

pub(crate) fn right() -> NurbsSurface {
    bicubic(DVec2::new(3.0, 0.0), DVec2::new(6.0, 3.0))
}

/// The part of a Bézier patch between two parameters v, as a patch of its own.
pub(crate) fn strip(surface: &NurbsSurface, from: f64, to: f64) -> NurbsSurface {
    let n = surface.degree_v + 1;
    let rows: Vec<Vec<DVec3>> = surface.points.chunks(n).map(|row| blossom(row, from, to)).collect();
    patch(&rows)
}

/// Control points of a part of a Bézier curve.
pub(crate) fn blossom(points: &[DVec3], from: f64, to: f64) -> Vec<DVec3> {
    let n = points.len();
    let point = |k: usize| {
        let mut row = points.to_vec();
        for step in 1..n {
            let t = if step <= k { to } else { from };
            row = row.windows(2).map(|w| w[0].lerp(w[1], t)).collect();
        }
        row[0]
    };
    (0..n).map(point).collect()
}

/// The surface with u and v exchanged.
pub(crate) fn transposed(s: &NurbsSurface) -> NurbsSurface {
    let (nu, nv) = (s.points.len() / (s.knots_v.len() - s.degree_v - 1), s.knots_v.len() - s.degree_v - 1);
    NurbsSurface {
        degree_u: s.degree_v,
        degree_v: s.degree_u,
        knots_u: s.knots_v.clone(),
        knots_v: s.knots_u.clone(),
        points: (0..nv).flat_map(|j| (0..nu).map(move |i| s.points[i * nv + j])).collect(),
        weights: (0..if s.weights.is_empty() { 0 } else { nv })
            .flat_map(|j| (0..nu).map(move |i| s.weights[i * nv + j]))
            .collect(),
    }
}

/// The surface with v reversed.
pub(crate) fn reversed_v(s: &NurbsSurface) -> NurbsSurface {
    let nv = s.knots_v.len() - s.degree_v - 1;
    let end = s.knots_v[nv];
    let turned = |row: &[DVec3]| row.iter().rev().copied().collect::<Vec<_>>();
    NurbsSurface {
        knots_v: s.knots_v.iter().rev().map(|k| end - k).collect(),
        points: s.points.chunks(nv).flat_map(turned).collect(),
        weights: s.weights.chunks(nv).flat_map(|row| row.iter().rev().copied().collect::<Vec<_>>()).collect(),
        ..s.clone()
    }
}

pub(crate) fn part(surfaces: impl IntoIterator<Item = NurbsSurface>) -> Part {
    trimmed(surfaces.into_iter().map(|s| (s, FreeTrims::default())))
}

/// Faces with free trims, or untrimmed where there are no curves.
pub(crate) fn trimmed(faces: impl IntoIterator<Item = (NurbsSurface, FreeTrims)>) -> Part {
    let mut part = PartBuilder::new("patches");
    let shell = part.plain_shell(ShellKind::Open);
    for (surface, trims) in faces {
        let surface = Surface::Nurbs(surface);
        if trims.curves.is_empty() {
            part.plain_face(surface, shell, Vec::new(), false);
        } else {
            part.trimmed_face(surface, shell, trims, false);
        }
    }
    part.finish().unwrap()
}

pub(crate) fn prepared_within(part: Part, border_tolerance: f64) -> Arc<Prepared> {
    let options = PrepareOptions::DEFAULT.with_border_tolerance(border_tolerance);
    let prepared = prepare(Model::from(part), &options).unwrap();
    let bad: Vec<_> = prepared.diagnostics.iter().filter(|d| d.severity > Severity::Note).collect();
    assert!(bad.is_empty(), "{bad:?}");
    Arc::new(prepared)
}

pub(crate) fn prepared(part: Part) -> Arc<Prepared> {
    prepared_within(part, PrepareOptions::DEFAULT.border_tolerance)
}

pub(crate) fn open(prepared: &Prepared) -> OpenEdges {
    prepared.parts[0].open_edges()
}

/// Number of edges used by two or more faces.
pub(crate) fn shared(prepared: &Prepared) -> usize {
    let part = &prepared.parts[0];
    let faces = |uses: &[trimtess::prepare::internals::TileUse]| {
        let mut faces: Vec<_> = uses.iter().map(|u| part.tiles[u.tile.index()].face).collect();
        faces.sort_unstable();
        faces.dedup();
        faces.len()
    };
    part.edges[..part.brep_edges].iter().filter(|e| faces(&e.uses) > 1).count()
}

pub(crate) fn mesh(prepared: &Arc<Prepared>, chord: f64) -> (MemorySink, MeshFacts) {
    let plan = plan(prepared, &Tolerance { chord: chord * prepared.diagonal, angle: 0.5, max_edge: None });
    let sink = whole_frame(prepared, &plan, false);
    let facts = check_scene(&sink).total;
    (sink, facts)
}

#[test]
fn a_face_that_ends_because_its_surface_does_is_open_there() {
    // A tube with one ring around it: the face goes on to the tube's upper end.
    let mut part = PartBuilder::new("tube");
    let shell = part.plain_shell(ShellKind::Open);
    let ring = part.circle(&Frame3 { origin: 2.0 * DVec3::Z, ..Frame3::WORLD }, 2.0);
    let curve = NurbsCurve3::line(DVec3::new(2.0, 0.0, 0.0), DVec3::new(2.0, 0.0, 5.0));
    let tube = Surface::Revolution { curve, frame: Frame3::WORLD };
    part.plain_face(tube, shell, vec![Loop::Edges(vec![ring.along()])], false);
    let prepared = Arc::new(prepare(Model::from(part.finish().unwrap()), &PrepareOptions::DEFAULT).unwrap());
    ends_where_it_is_open(&prepared);
}

/// Asserts at three tolerances that the mesh ends at the open edges and nowhere else: both have the same length.
pub(crate) fn ends_where_it_is_open(prepared: &Arc<Prepared>) {
    let open = open(prepared);
    for chord in [1e-2, 1e-3, 1e-4] {
        let facts = mesh(prepared, chord).1;
        assert!(facts.is_well_formed() && facts.zero_area == 0, "{facts}");
        let off = (facts.unbalanced_length - open.length).abs();
        assert!(off <= 20.0 * chord * open.length.max(0.01 * prepared.diagonal), "{chord}: {open:?}, {facts}");
        assert_eq!(facts.open_edges == 0, open.count == 0, "{chord}: {open:?}, {facts}");
    }
}
