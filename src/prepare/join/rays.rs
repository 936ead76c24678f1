//! Faces that close -> whether they look away from what they enclose, and whether they lie outside of what others
//! enclose, by straight lines through them.
//!
//! A line that starts on a face and leaves it along its normal crosses the others an even number of times if the face
//! looks outwards. That is sharp however thin the body is, where volumes from samples are a small difference of large
//! numbers. Crossings are found on the exact surfaces; a line that meets an edge, or touches a face, does not count.

use crate::control::Call;
use crate::math::bernstein::{basis_with_derivatives, restrict, restrict_rows, with_rows};
use crate::math::boxes::{Aabb, around};
use crate::prepare::surface::decompose::BezierPatches;
use crate::prepare::tiles::draft::{DraftTile, DraftUse, FaceDraft};
use crate::prepare::uv::polygon::{TileRegion, points_along};
use crate::prepare::wires::boundary::sign;
use glam::{DVec2, DVec3};
use smallvec::SmallVec;
use std::cell::{Cell, OnceCell};

/// Points along a loop in (u,v), at most `most` per use; one where it is straight, if `flat`.
pub(super) fn plane_polygon(uses: &[DraftUse], most: usize, flat: bool) -> Vec<DVec2> {
    let mut out = Vec::with_capacity(2 * uses.len());
    for u in uses {
        points_along(&u.uv, (u.from, u.to), most, flat, &mut out);
    }
    out
}

/// The region of a tile, with at most `most` points per use.
pub(super) fn region<'a>(draft: &'a FaceDraft, tile: &DraftTile, most: usize) -> TileRegion<'a> {
    let loops = tile.loops.iter().map(|l| plane_polygon(l, most, true)).collect();
    TileRegion { patches: &draft.surface.patches, min: tile.min, max: tile.max, loops }
}

/// Lines that are tried.
const LINES: usize = 24;

/// Lines that have to agree. A body that crosses itself may look outwards on one line and inwards on another.
const ENOUGH: usize = 3;

/// One face of a group that closes.
pub(super) struct RayFace<'a> {
    pub(super) draft: &'a FaceDraft,
    /// Whether its outward normal is opposite to `S_u × S_v`.
    pub(super) reversed: bool,
    /// Corners of a box around its surface.
    bounds: Aabb,
    /// The regions of its tiles. Most faces are far from all lines.
    tiles: OnceCell<Vec<TileRegion<'a>>>,
}

impl<'a> RayFace<'a> {
    pub(super) fn new(draft: &'a FaceDraft, reversed: bool) -> Self {
        let bounds = around(draft.surface.bounds.places.iter().flat_map(|place| [place.low, place.high]));
        Self { draft, reversed, bounds, tiles: OnceCell::new() }
    }

    fn tiles(&self) -> &[TileRegion<'a>] {
        self.tiles.get_or_init(|| self.draft.tiles.iter().map(|tile| region(self.draft, tile, usize::MAX)).collect())
    }
}

/// Faces that enclose something, to which others are compared.
pub(super) struct RayBody<'a> {
    pub(super) faces: Vec<RayFace<'a>>,
    /// Corners of a box around them.
    bounds: Aabb,
}

impl<'a> RayBody<'a> {
    pub(super) fn new(faces: Vec<RayFace<'a>>) -> Self {
        Self { bounds: bounds(&faces), faces }
    }
}

/// Whether the faces look away from what they enclose. `None` if lines do not agree, or too few are clear of edges.
pub(super) fn look_outwards(call: Call<'_>, faces: &[RayFace<'_>]) -> Option<bool> {
    let [low, high] = bounds(faces);
    let size = (high - low).length();
    agreed(call, faces, |line| match line.crossings(faces, size)? {
        (1, 0, -1) => Some(true),
        (1, -1, 0) => Some(false),
        _ => None,
    })
}

/// Whether the faces lie outside of what the faces of a `body` enclose. `None` as for [`look_outwards`], and if lines
/// take more tests of faces of the body than are `left`.
pub(super) fn lie_outside(
    call: Call<'_>,
    faces: &[RayFace<'_>],
    body: &RayBody<'_>,
    left: &Cell<usize>,
) -> Option<bool> {
    let ([low, high], other) = (bounds(faces), body.bounds);
    if low.cmpgt(other[1]).any() || other[0].cmpgt(high).any() {
        return Some(true);
    }
    let size = (other[1] - other[0]).length();
    agreed(call, faces, |line| {
        left.set(left.get().checked_sub(body.faces.len())?);
        match line.crossings(&body.faces, size)? {
            (0, 0, 0) => Some(true),
            (0, 1, -1) | (0, -1, 1) => Some(false),
            _ => None,
        }
    })
}

/// Corners of a box around faces.
fn bounds(faces: &[RayFace<'_>]) -> Aabb {
    around(faces.iter().flat_map(|face| face.bounds))
}

/// What enough lines from faces say, if all that say anything agree.
fn agreed(call: Call<'_>, faces: &[RayFace<'_>], says: impl Fn(&Line) -> Option<bool>) -> Option<bool> {
    let mut said: SmallVec<[bool; ENOUGH]> = SmallVec::new();
    for k in (0..LINES).take_while(|_| !call.is_cancelled()) {
        // Faces a golden section apart: neighbours in the file are neighbours in space.
        let share = (0.618_033_988_749_895 * k as f64).fract();
        let face = faces.get((share * faces.len() as f64) as usize)?;
        said.extend(start(face, k).and_then(|line| says(&line)));
        if said.windows(2).any(|w| w[0] != w[1]) {
            return None;
        }
        if said.len() == ENOUGH {
            return said.first().copied();
        }
    }
    None
}

/// A line that starts on a face, on the side to which that looks.
struct Line {
    from: DVec3,
    along: DVec3,
    across: [DVec3; 2],
}

/// The line `k` from a face. `None` if no sample is within its loops, or there is no normal.
fn start(face: &RayFace<'_>, k: usize) -> Option<Line> {
    /// Samples per Bézier piece and direction among which one is taken.
    const LATTICE: usize = 5;
    /// Samples that are tried.
    const TRIES: usize = 12;
    /// By which the line leans from the normal: symmetric bodies have edges and poles along their normals.
    const LEAN: [f64; 2] = [0.17, 0.11];
    let tiles = face.tiles();
    let tile = tiles.get(k % tiles.len().max(1))?;
    let samples: Vec<DVec2> = tile.lattice(LATTICE).1.collect();
    let tried = (0..TRIES).map(|t| samples[(7 * (k + t) + 3) % samples.len()]);
    let (uv, winding) = tried.map(|uv| (uv, tile.winding(uv))).find(|(_, winding)| winding.abs() == 1)?;
    let [from, du, dv] = face.draft.surface.patches.tangents(uv.x, uv.y);
    let normal = du.cross(dv).try_normalize()? * f64::from(sign(face.reversed) * winding);
    let across = normal.any_orthonormal_pair();
    let along = (normal + across.0 * LEAN[0] + across.1 * LEAN[1]).try_normalize()?;
    let across = along.any_orthonormal_pair();
    Some(Line { from, along, across: [across.0, across.1] })
}

impl Line {
    /// How often the line crosses faces at its start; and how often it leaves what they bound ahead of its start, and
    /// behind it, less the times that it enters. All crossings with a closed surface cancel. `None` if they are not
    /// certain.
    fn crossings(&self, faces: &[RayFace<'_>], size: f64) -> Option<(i32, i32, i32)> {
        /// Share of the size within which a crossing is the start.
        const NEAR: f64 = 1e-8;
        let (mut ahead, mut behind, mut starts) = (0, 0, 0);
        for face in faces.iter().filter(|face| self.is_near(face.bounds)) {
            for uv in self.cross(&face.draft.surface.patches)? {
                let (distance, turns) = self.crossing(face, uv)?;
                if distance.abs() <= NEAR * size {
                    starts += turns.abs();
                } else if distance > 0.0 {
                    ahead += turns;
                } else {
                    behind += turns;
                }
            }
        }
        Some((starts, ahead, behind))
    }

    /// Whether the line may meet a box.
    fn is_near(&self, [low, high]: Aabb) -> bool {
        let (from_line, half) = (0.5 * (low + high) - self.from, 0.5 * (high - low));
        self.across.iter().all(|across| from_line.dot(*across).abs() <= half.dot(across.abs()))
    }

    /// Distance of a crossing from the start, and how often the line leaves what the face bounds there: -1 where it
    /// enters. `None` close to an edge, or where the line touches the surface.
    fn crossing(&self, face: &RayFace<'_>, uv: DVec2) -> Option<(f64, i32)> {
        /// Share of a tile's sides that a crossing has to be away from its loops, which are polygons here.
        const CLEAR: f64 = 0.005;
        /// Least sine of the angle between line and surface.
        const STEEP: f64 = 1e-6;
        let mut winding = 0;
        for tile in face.tiles() {
            let off = CLEAR * (tile.max - tile.min);
            if uv.cmplt(tile.min - off).any() || uv.cmpgt(tile.max + off).any() {
                continue;
            }
            let here = tile.winding(uv);
            let corners = [off, -off, DVec2::new(off.x, -off.y), DVec2::new(-off.x, off.y)];
            if corners.iter().any(|corner| tile.winding(uv + corner) != here) {
                return None;
            }
            winding += here;
        }
        let [point, du, dv] = face.draft.surface.patches.tangents(uv.x, uv.y);
        let normal = du.cross(dv);
        let steep = normal.dot(self.along);
        if winding != 0 && steep.abs() <= STEEP * normal.length() {
            return None;
        }
        let leaves = if (steep > 0.0) != face.reversed { 1 } else { -1 };
        Some(((point - self.from).dot(self.along), leaves * winding))
    }

    /// The parameters of each point of the surface on the line. `None` if there may be others.
    fn cross(&self, patches: &BezierPatches) -> Option<Zeros> {
        let mut found = Zeros::new();
        let (count_u, count_v) = patches.counts();
        for (i, j) in (0..count_u).flat_map(|i| (0..count_v).map(move |j| (i, j))) {
            let off = |at: DVec3, w: f64| {
                let from_line = at - self.from * w;
                DVec2::new(from_line.dot(self.across[0]), from_line.dot(self.across[1]))
            };
            let net = patches.patch(i, j).iter().map(|c| off(c.truncate(), c.w)).collect();
            let (u, v) = (&patches.breaks_u[i..], &patches.breaks_v[j..]);
            let place = |at: DVec2| DVec2::new(u[0] + (u[1] - u[0]) * at.x, v[0] + (v[1] - v[0]) * at.y);
            found.extend(zeros(net, patches.degree_v + 1)?.into_iter().map(place));
        }
        Some(found)
    }
}

/// A Bézier net in the plane, u-major.
type Net = SmallVec<[DVec2; 16]>;

/// Parameters of points on a line.
type Zeros = SmallVec<[DVec2; 4]>;

/// The parameters at which a polynomial map of the unit square is zero. `width`: coefficients in v. `None` if there may
/// be others.
///
/// Halves the square. A part whose coefficients all lie on one side of an axis has no zero. A part over which the map
/// is one to one has one at most, which Newton's method finds.
fn zeros(net: Net, width: usize) -> Option<Zeros> {
    /// Parts of a patch that are looked at. A simple zero takes about ten.
    const MOST: usize = 400;
    /// Side of a part that contains no simple zero: in smaller ones, signs of coefficients are rounding.
    const SMALLEST: f64 = 1e-6;
    /// Share of a part's side that a zero has to be away from its border: there, two parts or none may find it.
    const BORDER: f64 = 1e-7;
    let may_have = |net: &Net| {
        let misses = |axis: usize| net.iter().all(|c| c[axis] > 0.0) || net.iter().all(|c| c[axis] < 0.0);
        !misses(0) && !misses(1)
    };
    let mut parts: SmallVec<[(Net, DVec2, DVec2); 8]> = SmallVec::new();
    if may_have(&net) {
        parts.push((net, DVec2::ZERO, DVec2::ONE));
    }
    let (mut found, mut looked) = (Zeros::new(), 0);
    while let Some((net, low, high)) = parts.pop() {
        looked += 1;
        if looked > MOST || (high - low).max_element() < SMALLEST {
            return None;
        }
        if is_one_to_one(&net, width)
            && let Some(at) = newton(&net, width)
        {
            if (0..2).any(|axis| at[axis] < BORDER || at[axis] > 1.0 - BORDER) {
                return None;
            }
            found.push(low + (high - low) * at);
            continue;
        }
        let (size, middle) = (high - low, 0.5 * (low + high));
        for half in [[0.0, 0.5], [0.5, 1.0]] {
            let (mut net, mut low, mut high) = (Net::from_slice(&net), low, high);
            let axis = usize::from(size.y > size.x);
            if axis == 0 {
                restrict_rows(&mut net, width, half[0], half[1]);
            } else {
                net.chunks_exact_mut(width).for_each(|row| restrict(row, half[0], half[1]));
            }
            if !may_have(&net) {
                continue;
            }
            if half[0] == 0.0 {
                high[axis] = middle[axis];
            } else {
                low[axis] = middle[axis];
            }
            parts.push((net, low, high));
        }
    }
    Some(found)
}

/// Whether every difference of coefficients along u is on one side of every one along v. Then no two points have the
/// same image: their difference is a sum of means of both.
fn is_one_to_one(net: &Net, width: usize) -> bool {
    let along_u = || net.iter().zip(&net[width..]).map(|(a, b)| *b - *a);
    let along_v = || net.chunks_exact(width).flat_map(|row| row.windows(2)).map(|w| w[1] - w[0]);
    let turns = || along_u().flat_map(|u| along_v().map(move |v| u.perp_dot(v)));
    turns().all(|turn| turn > 0.0) || turns().all(|turn| turn < 0.0)
}

/// The zero within the unit square to which Newton's method converges from its middle.
fn newton(net: &Net, width: usize) -> Option<DVec2> {
    const STEPS: usize = 20;
    /// Length of the last step: the error left is about its square.
    const SHORT: f64 = 1e-8;
    let mut at = DVec2::splat(0.5);
    for _ in 0..STEPS {
        let [value, du, dv] = value_and_slopes(net, width, at);
        let step = DVec2::new(value.perp_dot(dv), du.perp_dot(value)) / du.perp_dot(dv);
        at -= step;
        if !(at.min_element() >= 0.0 && at.max_element() <= 1.0) {
            return None;
        }
        if step.abs().max_element() <= SHORT {
            return Some(at);
        }
    }
    None
}

/// The map and its derivatives by u and v.
fn value_and_slopes(net: &Net, width: usize, at: DVec2) -> [DVec2; 3] {
    let degrees = (net.len() / width - 1, width - 1);
    with_rows(degrees.0, |rows_u| {
        with_rows(degrees.1, |rows_v| {
            basis_with_derivatives(degrees.0, at.x, rows_u);
            basis_with_derivatives(degrees.1, at.y, rows_v);
            let sum = |along_u: &[f64], along_v: &[f64]| {
                let rows = net.chunks_exact(width).zip(along_u);
                rows.flat_map(|(row, n)| row.iter().zip(along_v).map(move |(c, m)| *c * (n * m))).sum()
            };
            let ((n, dn), (m, dm)) = (rows_u.split_at(degrees.0 + 1), rows_v.split_at(width));
            [sum(n, m), sum(dn, m), sum(n, dm)]
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The square of a complex number, less `(0.2 + 0.1 i)²`, by coefficients of degree 2 in both directions.
    fn square(middle: DVec2) -> Net {
        let line = |s: f64| [-s, 0.5 - s, 1.0 - s];
        let parabola = |s: f64| [s * s, -s * (1.0 - s), (1.0 - s) * (1.0 - s)];
        let at = |i: usize, j: usize| {
            let real = parabola(middle.x)[i] - parabola(middle.y)[j];
            DVec2::new(real, 2.0 * line(middle.x)[i] * line(middle.y)[j]) - DVec2::new(0.03, 0.04)
        };
        (0..3).flat_map(|i| (0..3).map(move |j| (i, j))).map(|(i, j)| at(i, j)).collect()
    }

    #[test]
    fn zeros_are_found_unless_they_are_on_a_border() {
        let off = DVec2::new(0.2, 0.1);
        // Both within the square, one of them, none.
        for middle in [DVec2::new(0.34, 0.41), DVec2::new(0.13, 0.33), DVec2::new(1.3, 0.4)] {
            let mut found = zeros(square(middle), 3).expect("certain zeros");
            found.sort_by(|a, b| a.x.total_cmp(&b.x));
            let inside = |at: &DVec2| at.min_element() > 0.0 && at.max_element() < 1.0;
            let expected: Vec<DVec2> = [middle - off, middle + off].into_iter().filter(inside).collect();
            let close = found.iter().zip(&expected).all(|(a, b)| a.distance(*b) < 1e-12);
            assert!(found.len() == expected.len() && close, "{middle}: {found:?} instead of {expected:?}");
        }
        // One at the lower end of u; a double one.
        assert_eq!(zeros(square(DVec2::new(0.2, 0.4)), 3), None);
        let double = square(DVec2::new(0.34, 0.41)).iter().map(|c| *c + DVec2::new(0.03, 0.04)).collect();
        assert_eq!(zeros(double, 3), None);
    }
}
