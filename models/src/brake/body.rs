//! Paths -> sides of solids, turned about an axis or swept along an outline, with edges shared between neighbours.
//!
//! Everything is oriented as seen from outside: a path has the material on its left, and a returned ring is oriented
//! for the neighbour's boundary. `finish` reverses the loops of sides whose surface normal points inwards.

use super::path::{Path, Piece, lifted, meridian, right};
use glam::{DVec2, DVec3};
use trimtess::model::{
    Coedge, Colour, CurveKind, EdgeId, Face, Frame3, Loop, NurbsCurve3, Part, PartBuilder, ShellKind, Surface, VertexId,
};

/// Lengths below this are rounding errors, millimetres.
const ROUNDING: f64 = 1e-9;

/// A closed chain of coedges.
pub(super) type Ring = Vec<Coedge>;

/// A side of a [`Body`].
#[derive(Clone, Copy, Debug)]
pub(super) struct SideId(usize);

struct Side {
    surface: Surface,
    /// Whether the surface's normal points into the material.
    reversed: bool,
    colour: Option<Colour>,
    /// Oriented as seen from outside.
    loops: Vec<Loop>,
}

/// A builder of a closed solid.
pub(super) struct Body {
    part: PartBuilder,
    shell: u32,
    sides: Vec<Side>,
    /// Colour of sides added next, if not the part's.
    paint: Option<Colour>,
}

/// Result of [`Body::turn`] and [`Body::sweep`]: the sides per piece of the turned path (or of the outline, row by row
/// of the profile), and the boundaries of the neighbours at the start and end of the turned path (or of the profile).
pub(super) struct Made {
    pub(super) sides: Vec<SideId>,
    start: Option<Ring>,
    end: Option<Ring>,
}

/// Reverses a ring, as the side across it uses it.
fn turned_over(ring: &[Coedge]) -> Ring {
    let over = |coedge: &Coedge| if coedge.reversed { coedge.edge.along() } else { coedge.edge.against() };
    ring.iter().rev().map(over).collect()
}

impl Body {
    pub(super) fn new(name: &str, colour: Colour) -> Self {
        let mut part = PartBuilder::new(name);
        part.colour(colour);
        let shell = part.plain_shell(ShellKind::Outer);
        Self { part, shell, sides: Vec::new(), paint: None }
    }

    /// Builds the part.
    pub(super) fn finish(mut self) -> Part {
        for Side { surface, reversed, colour, loops } in self.sides {
            let turned = |boundary| match boundary {
                Loop::Edges(ring) if reversed => Loop::Edges(turned_over(&ring)),
                other => other,
            };
            let loops = loops.into_iter().map(turned).collect();
            self.part.face(Face { colour, ..Face::new(surface, self.shell, loops, reversed) });
        }
        self.part.finish().expect("the brake's parts are stated soundly")
    }

    /// Sets the colour of sides added next.
    pub(super) fn paint(&mut self, colour: Colour) {
        self.paint = Some(colour);
    }

    /// Adds a side without boundary. `reversed` if the surface's normal points into the material.
    pub(super) fn side(&mut self, surface: Surface, reversed: bool) -> SideId {
        self.sides.push(Side { surface, reversed, colour: self.paint, loops: Vec::new() });
        SideId(self.sides.len() - 1)
    }

    /// Adds a plane side without boundary.
    pub(super) fn flat(&mut self, origin: DVec3, outwards: DVec3) -> SideId {
        let frame = Frame3::from_axis(origin, outwards, outwards.any_orthogonal_vector()).expect("a direction");
        self.side(Surface::Plane { frame }, false)
    }

    /// Adds a boundary loop, oriented as seen from outside.
    pub(super) fn bound(&mut self, side: SideId, ring: Ring) {
        self.sides[side.0].loops.push(Loop::Edges(ring));
    }

    pub(super) fn vertex(&mut self, point: DVec3) -> VertexId {
        self.part.vertex(point)
    }

    pub(super) fn edge(&mut self, (curve, kind): (NurbsCurve3, CurveKind), start: VertexId, end: VertexId) -> EdgeId {
        self.part.curve(curve, kind, start, end)
    }

    pub(super) fn line(&mut self, start: VertexId, end: VertexId) -> EdgeId {
        self.part.line(start, end)
    }

    /// Adds a full circle about the frame's z, counter-clockwise.
    pub(super) fn circle(&mut self, frame: &Frame3, radius: f64) -> EdgeId {
        self.part.circle(frame, radius)
    }

    /// Adds the boundaries at start and end of `made` to its neighbours. An end on the axis has no neighbour.
    pub(super) fn join(&mut self, made: &mut Made, start: Option<SideId>, end: Option<SideId>) {
        for (ring, side) in [(made.start.take(), start), (made.end.take(), end)] {
            if let (Some(ring), Some(side)) = (ring, side) {
                self.bound(side, ring);
            }
        }
    }

    /// Revolves `path`, in (distance from the axis, height), about the frame's z axis.
    pub(super) fn turn(&mut self, frame: &Frame3, path: &Path) -> Made {
        let rings: Vec<Option<EdgeId>> =
            path.points.iter().map(|p| (p.x > 0.0).then(|| self.part.circle(&lifted(frame, p.y), p.x))).collect();
        let mut sides = Vec::with_capacity(path.pieces.len());
        for (k, piece) in path.pieces.iter().enumerate() {
            let (p, q) = (path.points[k], path.end(k));
            let (surface, reversed) = match *piece {
                Piece::Line => straight(frame, p, q - p),
                Piece::Arc { centre, turn } => {
                    (round(&lifted(frame, centre.y), centre.x, p.distance(centre)), turn < 0.0)
                }
                Piece::Cubic(_) => {
                    let (curve, _) = path.curve(k, &meridian(frame, DVec2::ZERO, DVec2::X), 0.0, 0.0);
                    (Surface::Revolution { curve, frame: *frame }, false)
                }
            };
            let apex = if p.x == 0.0 { Some(p) } else { Some(q).filter(|q| q.x == 0.0) };
            let apex = apex.filter(|_| matches!(surface, Surface::Cone { .. }));
            let side = self.side(surface, reversed);
            let [start, end] = [k, (k + 1) % path.points.len()].map(|n| rings[n]);
            for ring in [start.map(EdgeId::along), end.map(EdgeId::against)].into_iter().flatten() {
                self.bound(side, vec![ring]);
            }
            if let Some(apex) = apex {
                let tip = self.vertex(frame.place(DVec3::Z * apex.y));
                self.sides[side.0].loops.push(Loop::Vertex(tip));
            }
            sides.push(side);
        }
        let open = !path.is_closed();
        let last = rings.len() - 1;
        let start = rings[0].filter(|_| open).map(|ring| vec![ring.against()]);
        let end = rings[last].filter(|_| open).map(|ring| vec![ring.along()]);
        Made { sides, start, end }
    }

    /// Sweeps `profile`, in (distance to the right of the outline, height), along the closed `outline` in the frame's
    /// plane. Unless the profile stays on the outline, the outline must be smooth.
    pub(super) fn sweep(&mut self, frame: &Frame3, outline: &Path, profile: &Path) -> Made {
        let (n, m) = (outline.pieces.len(), profile.pieces.len());
        let mut rings: Vec<Vec<EdgeId>> = Vec::with_capacity(m + 1);
        let mut vertices: Vec<Vec<VertexId>> = Vec::with_capacity(m + 1);
        for at in &profile.points {
            let corner = |k: usize| outline.points[k] + right(outline.tangent(k)) * at.x;
            let row: Vec<VertexId> = (0..n).map(|k| self.vertex(frame.place(corner(k).extend(at.y)))).collect();
            let edge = |k: usize| {
                let curve = outline.curve(k, frame, at.x, at.y);
                self.edge(curve, row[k], row[(k + 1) % n])
            };
            rings.push((0..n).map(edge).collect());
            vertices.push(row);
        }
        let mut rails: Vec<Vec<EdgeId>> = Vec::with_capacity(m);
        for j in 0..m {
            let rail = |k: usize| {
                let plane = meridian(frame, outline.points[k], right(outline.tangent(k)));
                self.edge(profile.curve(j, &plane, 0.0, 0.0), vertices[j][k], vertices[j + 1][k])
            };
            rails.push((0..n).map(rail).collect());
        }
        let mut sides = Vec::with_capacity(n * m);
        for j in 0..m {
            for k in 0..n {
                let (surface, reversed) = swept(frame, outline, k, profile, j);
                let side = self.side(surface, reversed);
                let next = rails[j][(k + 1) % n];
                self.bound(
                    side,
                    vec![rings[j][k].along(), next.along(), rings[j + 1][k].against(), rails[j][k].against()],
                );
                sides.push(side);
            }
        }
        let start = rings[0].iter().rev().map(|ring| ring.against()).collect();
        let end = rings[m].iter().map(|ring| ring.along()).collect();
        Made { sides, start: Some(start), end: Some(end) }
    }
}

/// The surface of revolution of a line from `p` by `d`, in (distance from the axis, height), and whether its normal
/// points into the material.
fn straight(frame: &Frame3, p: DVec2, d: DVec2) -> (Surface, bool) {
    let at = lifted(frame, p.y);
    if d.y.abs() < ROUNDING {
        // The outward normal is up if the path leads towards the axis.
        return (Surface::Plane { frame: at }, d.x > 0.0);
    }
    let surface = if d.x.abs() < ROUNDING {
        Surface::Cylinder { frame: at, radius: p.x }
    } else {
        Surface::Cone { frame: at, radius: p.x, half_angle: (d.x / d.y).atan() }
    };
    (surface, d.y < 0.0)
}

/// The surface of revolution of a circle of radius `minor` with its centre at distance `major` from the axis.
fn round(frame: &Frame3, major: f64, minor: f64) -> Surface {
    if major.abs() < ROUNDING {
        Surface::Sphere { frame: *frame, radius: minor }
    } else {
        Surface::Torus { frame: *frame, major, minor }
    }
}

/// The surface of piece `j` of the profile along piece `k` of the outline, and whether its normal points into the
/// material.
fn swept(frame: &Frame3, outline: &Path, k: usize, profile: &Path, j: usize) -> (Surface, bool) {
    let (corner, tangent) = (outline.points[k], outline.tangent(k));
    let p = profile.points[j];
    let d = profile.end(j) - p;
    let across = meridian(frame, corner, right(tangent));
    match (outline.pieces[k], profile.pieces[j]) {
        (Piece::Line, Piece::Line) => {
            let along = -across.z;
            let up = across.x * d.x + across.y * d.y;
            let plane = Frame3::from_axis(across.place(p.extend(0.0)), along.cross(up), along);
            (Surface::Plane { frame: plane.expect("a profile goes on") }, false)
        }
        (Piece::Line, Piece::Arc { centre, turn }) => {
            let axis = Frame3 { origin: across.place(centre.extend(0.0)), ..across };
            (Surface::Cylinder { frame: axis, radius: p.distance(centre) }, turn < 0.0)
        }
        (Piece::Arc { centre, turn }, piece) => {
            // About the arc's centre, with the angle counted from its start.
            let axis = meridian(frame, centre, (corner - centre).normalize());
            let axis = Frame3 { origin: axis.origin, x: axis.x, y: frame.z.cross(axis.x), z: frame.z };
            let outwards = turn.signum();
            let radius = |offset: f64| corner.distance(centre) + outwards * offset;
            match piece {
                Piece::Arc { centre, turn } => {
                    (round(&lifted(&axis, centre.y), radius(centre.x), p.distance(centre)), turn < 0.0)
                }
                _ => {
                    let (surface, reversed) =
                        straight(&axis, DVec2::new(radius(p.x), p.y), d * DVec2::new(outwards, 1.0));
                    (surface, reversed != (outwards < 0.0))
                }
            }
        }
        (Piece::Cubic(_), _) | (_, Piece::Cubic(_)) => {
            let (curve, _) = outline.curve(k, frame, p.x, p.y);
            (Surface::Extrusion { curve, direction: frame.z }, d.y < 0.0)
        }
    }
}
