//! Corners with radii, or points and arcs -> plane paths of lines, circular arcs and cubic Bézier pieces, to be swept
//! or revolved.

use glam::{DVec2, DVec3};
use trimtess::model::{CurveKind, Frame3, NurbsCurve3};

/// A piece of a path between two points.
#[derive(Clone, Copy, Debug)]
pub(super) enum Piece {
    Line,
    /// A circular arc about `centre` by the angle `turn`, counter-clockwise if positive, less than a full turn.
    Arc {
        centre: DVec2,
        turn: f64,
    },
    /// A cubic Bézier piece with these inner control points.
    Cubic([DVec2; 2]),
}

/// Points and the pieces between them: as many pieces as points if closed, else one less.
#[derive(Clone, Debug, Default)]
pub(super) struct Path {
    pub(super) points: Vec<DVec2>,
    pub(super) pieces: Vec<Piece>,
}

/// The direction right of `d`.
pub(super) fn right(d: DVec2) -> DVec2 {
    DVec2::new(d.y, -d.x)
}

impl Path {
    /// Starts a path at a point.
    pub(super) fn from(start: impl Into<DVec2>) -> Self {
        Self { points: vec![start.into()], pieces: Vec::new() }
    }

    /// Appends a line.
    pub(super) fn line(&mut self, to: impl Into<DVec2>) -> &mut Self {
        self.points.push(to.into());
        self.pieces.push(Piece::Line);
        self
    }

    /// Appends an arc about `centre`.
    pub(super) fn arc(&mut self, centre: impl Into<DVec2>, turn: f64) -> &mut Self {
        let centre = centre.into();
        let last = self.points[self.points.len() - 1];
        self.points.push(centre + DVec2::from_angle(turn).rotate(last - centre));
        self.pieces.push(Piece::Arc { centre, turn });
        self
    }

    /// Appends a cubic Bézier piece with these inner control points.
    pub(super) fn cubic(&mut self, inner: [(f64, f64); 2], to: impl Into<DVec2>) -> &mut Self {
        self.points.push(to.into());
        self.pieces.push(Piece::Cubic(inner.map(DVec2::from)));
        self
    }

    /// Closes the path by removing its last point, which must equal the first up to rounding.
    pub(super) fn close(mut self) -> Self {
        self.points.pop();
        self
    }

    /// The open path along corners `(x, y, radius)`, rounded with these radii except at the ends.
    pub(super) fn open(corners: &[(f64, f64, f64)]) -> Self {
        let mut path = Self::default();
        for k in 0..corners.len() {
            let inner = k > 0 && k + 1 < corners.len();
            path.corner(corners, k, inner);
        }
        path
    }

    /// The closed path along corners `(x, y, radius)`, rounded with these radii.
    pub(super) fn closed(corners: &[(f64, f64, f64)]) -> Self {
        let mut path = Self::default();
        for k in 0..corners.len() {
            path.corner(corners, k, true);
        }
        path.pieces.push(Piece::Line);
        path
    }

    /// Appends a line to corner `k` and, if `inner`, the arc around it.
    fn corner(&mut self, corners: &[(f64, f64, f64)], k: usize, inner: bool) {
        let at = |k: usize| DVec2::new(corners[k].0, corners[k].1);
        let (corner, radius) = (at(k), corners[k].2);
        if !inner || radius == 0.0 {
            return self.reach(corner);
        }
        let before = (corner - at((k + corners.len() - 1) % corners.len())).normalize();
        let after = (at((k + 1) % corners.len()) - corner).normalize();
        let turn = before.angle_to(after);
        let cut = radius * (0.5 * turn.abs()).tan();
        let start = corner - before * cut;
        self.reach(start);
        self.pieces.push(Piece::Arc { centre: start - right(before) * (radius * turn.signum()), turn });
        self.points.push(corner + after * cut);
    }

    /// Appends a line to `to` unless the path is there already.
    fn reach(&mut self, to: DVec2) {
        match self.points.last() {
            Some(last) if last.distance(to) < 1e-9 => {}
            Some(_) => {
                self.line(to);
            }
            None => self.points.push(to),
        }
    }

    /// The closed uniform cubic B-spline with these control points, as Bézier pieces.
    pub(super) fn spline(controls: &[DVec2]) -> Self {
        let at = |k: usize| controls[k % controls.len()];
        let mut path = Self::default();
        for k in 0..controls.len() {
            let [a, b, c] = [at(k), at(k + 1), at(k + 2)];
            path.points.push((a + b * 4.0 + c) / 6.0);
            path.pieces.push(Piece::Cubic([(b * 2.0 + c) / 3.0, (b + c * 2.0) / 3.0]));
        }
        path
    }

    /// Rotates the path about the origin.
    pub(super) fn turned(&self, angle: f64) -> Self {
        let turn = |p: DVec2| DVec2::from_angle(angle).rotate(p);
        let piece = |piece: &Piece| match *piece {
            Piece::Line => Piece::Line,
            Piece::Arc { centre, turn: by } => Piece::Arc { centre: turn(centre), turn: by },
            Piece::Cubic(inner) => Piece::Cubic(inner.map(turn)),
        };
        Self { points: self.points.iter().map(|&p| turn(p)).collect(), pieces: self.pieces.iter().map(piece).collect() }
    }

    /// Reverses a closed path.
    pub(super) fn reversed(&self) -> Self {
        let piece = |piece: &Piece| match *piece {
            Piece::Line => Piece::Line,
            Piece::Arc { centre, turn } => Piece::Arc { centre, turn: -turn },
            Piece::Cubic([b, c]) => Piece::Cubic([c, b]),
        };
        // The last piece leads back to the first point.
        let points = self.points.first().into_iter().chain(self.points.iter().skip(1).rev());
        Self { points: points.copied().collect(), pieces: self.pieces.iter().rev().map(piece).collect() }
    }

    pub(super) fn is_closed(&self) -> bool {
        self.points.len() == self.pieces.len()
    }

    /// End of piece `k`.
    pub(super) fn end(&self, k: usize) -> DVec2 {
        self.points[(k + 1) % self.points.len()]
    }

    /// Unit tangent at the start of piece `k`.
    pub(super) fn tangent(&self, k: usize) -> DVec2 {
        let start = self.points[k];
        match self.pieces[k] {
            Piece::Line => (self.end(k) - start).normalize(),
            Piece::Arc { centre, turn } => -right(start - centre).normalize() * turn.signum(),
            Piece::Cubic([b, _]) => (b - start).normalize(),
        }
    }

    /// The line that contains a point.
    ///
    /// # Panics
    /// If there is none. Callers pass points of lines that they have just made.
    pub(super) fn piece_through(&self, x: f64, y: f64) -> usize {
        let p = DVec2::new(x, y);
        let through = |&k: &usize| {
            let (a, b) = (self.points[k], self.end(k));
            matches!(self.pieces[k], Piece::Line) && a.distance(p) + p.distance(b) < a.distance(b) + 1e-9
        };
        (0..self.pieces.len()).find(through).expect("a piece that the model has just made")
    }

    /// Piece `k` offset to its right by `offset`, in the frame's plane z = `height`.
    pub(super) fn curve(&self, k: usize, frame: &Frame3, offset: f64, height: f64) -> (NurbsCurve3, CurveKind) {
        let place = |p: DVec2| frame.place(p.extend(height));
        let (a, b) = (self.points[k], self.end(k));
        match self.pieces[k] {
            Piece::Line => {
                let aside = right(self.tangent(k)) * offset;
                (NurbsCurve3::line(place(a + aside), place(b + aside)), CurveKind::Line)
            }
            Piece::Arc { centre, turn } => {
                let radius = a.distance(centre) + offset * turn.signum();
                // The frame's x axis points to the start, its y axis in the direction of travel.
                let start = (a - centre).normalize();
                let x = frame.place(start.extend(0.0)) - frame.origin;
                let z = frame.z * turn.signum();
                let arc = Frame3 { origin: place(centre), x, y: z.cross(x), z };
                (NurbsCurve3::arc(&arc, radius, radius, 0.0, turn.abs()), CurveKind::Circle)
            }
            Piece::Cubic([p, q]) => {
                let points = [a, p, q, b].map(place).to_vec();
                (NurbsCurve3::bezier(points, Vec::new()), CurveKind::Spline)
            }
        }
    }
}

/// The frame of a half plane parallel to the z axis of `frame`: x is the distance from `origin` in direction
/// `outwards`, y the height.
pub(super) fn meridian(frame: &Frame3, origin: DVec2, outwards: DVec2) -> Frame3 {
    let x = frame.place(outwards.extend(0.0)) - frame.origin;
    Frame3 { origin: frame.place(origin.extend(0.0)), x, y: frame.z, z: x.cross(frame.z) }
}

/// A frame moved along its z axis.
pub(super) fn lifted(frame: &Frame3, height: f64) -> Frame3 {
    Frame3 { origin: frame.place(DVec3::Z * height), ..*frame }
}
