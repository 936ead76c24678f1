//! Foot points of a projection: where to look for the nearest point of a surface, and what a step in space is in (u,v)
//! there.

use crate::math::solve::solve_symmetric;
use crate::model::{Surface, SurfaceDerivatives};
use glam::{DVec2, DVec3};

/// A point of the surface near a point in space.
#[derive(Clone, Copy)]
pub(super) struct Foot {
    /// Periodic parameters may lie outside the domain.
    pub(super) uv: DVec2,
    /// Distance in space.
    pub(super) off: f64,
    /// The surface's point and its derivatives by u and v.
    pub(super) tangents: [DVec3; 3],
}

impl Foot {
    /// No foot yet: any other is nearer.
    pub(super) fn none(uv: DVec2) -> Self {
        Self { uv, off: f64::INFINITY, tangents: [DVec3::NAN; 3] }
    }

    /// The foot of `p` at `uv`, where the surface has these tangents.
    pub(super) fn new(uv: DVec2, p: DVec3, tangents: [DVec3; 3]) -> Self {
        Self { uv, off: p.distance(tangents[0]), tangents }
    }
}

/// The step of Newton's method to the point nearest to the one that lies at `r` from here. Converges quadratically
/// where that is off the surface, while `least_squares` gains a fixed share of the distance per step. `None` where the
/// distance is not convex, or hardly.
pub(crate) fn newton_step(here: &SurfaceDerivatives, r: DVec3) -> Option<DVec2> {
    let SurfaceDerivatives { du, dv, duu, duv, dvv, .. } = *here;
    let matrix = [du.length_squared() - r.dot(duu), du.dot(dv) - r.dot(duv), dv.length_squared() - r.dot(dvv)];
    solve_symmetric(matrix, DVec2::new(r.dot(du), r.dot(dv)), 1e-3)
}

/// The velocity in (u,v) of a point that moves with velocity `c` in space; NaN where the surface is singular.
pub(super) fn jacobian_solve(a: DVec3, b: DVec3, c: DVec3) -> DVec2 {
    let (e, f, g) = (a.length_squared(), a.dot(b), b.length_squared());
    let is_even = e > 1e-18 * g && g > 1e-18 * e;
    let velocity = is_even.then(|| solve_symmetric([e, f, g], DVec2::new(c.dot(a), c.dot(b)), 1e-12));
    velocity.flatten().unwrap_or(DVec2::NAN)
}

/// Total number of seeds on surfaces of few spans. A search visits every one.
const FEW: usize = 64 * 64;
/// Total number of seeds.
const MOST: usize = 1 << 15;
/// Most seeds from which a search starts: of those that are nearer than all around them, and of all.
const MOST_LEAST: usize = 8;
const NEAREST: usize = 4;

/// A lattice of places on a surface.
pub(super) struct Seeds {
    /// Along u and along v.
    counts: [usize; 2],
    /// Whether the last one is next to the first.
    closed: [bool; 2],
    /// In u-major order.
    places: Vec<(DVec2, DVec3)>,
    /// The direction in which the surface extends without end. Distances along it do not count.
    sweep: Option<DVec3>,
}

impl Seeds {
    pub(super) fn of(surface: &Surface, domain: [(f64, f64); 2], period: [Option<f64>; 2]) -> Self {
        let wanted = |axis: usize| -> usize {
            let enough = match (surface, axis) {
                (Surface::Nurbs(s), 0) => s.count_u() * 2,
                (Surface::Nurbs(s), _) => s.count_v() * 2,
                (Surface::Extrusion { curve, .. }, 0) | (Surface::Revolution { curve, .. }, 1) => {
                    curve.points.len() * 3
                }
                (Surface::Extrusion { .. }, _) => return 1,
                _ => 16,
            };
            enough.clamp(8, 1024)
        };
        // One direction may use what the other does not need: a spring has many turns and one round section.
        let n = [wanted(0), wanted(1)];
        let even = [0, 1].map(|axis| n[axis].min((FEW / n[1 - axis].min(64)).max(64)));
        let breaks = surface.breaks();
        // Midpoints: on a pole line a derivative vanishes and Newton's method cannot move.
        let axis_values = |axis: usize| -> Vec<f64> {
            let (a, b) = domain[axis];
            let count = even[axis];
            if count == 1 {
                return vec![0.0];
            }
            // Each turn of a spring, and each tooth of a profile, has a span.
            let most = MOST / even[1 - axis].max(breaks[1 - axis].len());
            if (count..most).contains(&breaks[axis].len().saturating_sub(1)) {
                return breaks[axis].windows(2).map(|w| 0.5 * (w[0] + w[1])).collect();
            }
            let (a, b) = if a.is_finite() && b.is_finite() { (a, b) } else { (-1.0, 1.0) };
            (0..count).map(|k| a + (b - a) * (k as f64 + 0.5) / count as f64).collect()
        };
        let [us, vs] = [0, 1].map(axis_values);
        let counts = [us.len(), vs.len()];
        let pairs = us.iter().flat_map(|&u| vs.iter().map(move |&v| DVec2::new(u, v)));
        let places = pairs.zip(surface.lattice(&us, &vs)).collect();
        let sweep = match surface {
            Surface::Extrusion { direction, .. } => Some(direction.normalize_or_zero()),
            _ => None,
        };
        Self { counts, closed: period.map(|p| p.is_some()), places, sweep }
    }

    /// Where to start, best first: at the nearest seed, which is enough for most points; then at those that are nearer
    /// to `p` than all around them, and at the next nearest ones. Where a surface passes `p` several times, as the
    /// turns of a spring do, the nearest seeds may all be on the wrong turn.
    pub(super) fn starts(&self, p: DVec3) -> impl Iterator<Item = DVec2> {
        let mut distances = Vec::with_capacity(self.places.len());
        let mut nearest = [(f64::INFINITY, 0); NEAREST];
        for (k, (_, place)) in self.places.iter().enumerate() {
            let off = p - *place;
            let distance = self.sweep.map_or(off, |sweep| off - sweep * off.dot(sweep)).length_squared();
            distances.push(distance);
            if distance < nearest[NEAREST - 1].0 {
                nearest[NEAREST - 1] = (distance, k);
                nearest.sort_by(|a, b| a.0.total_cmp(&b.0));
            }
        }
        let [first, next @ ..] = nearest.map(|(distance, k)| distance.is_finite().then_some(k));
        let others = std::iter::once_with(move || self.others(&distances, first, next)).flatten();
        first.into_iter().chain(others).map(|k| self.places[k].0)
    }

    /// The starts after the first.
    fn others(&self, distances: &[f64], first: Option<usize>, next: [Option<usize>; NEAREST - 1]) -> Vec<usize> {
        let [rows, row] = self.counts;
        let mut starts = Vec::new();
        for i in 0..rows {
            let us = self.around(0, i);
            let is_other = |j: &usize| Some(i * row + j) != first && self.is_least(distances, us, *j);
            starts.extend((0..row).filter(is_other).map(|j| i * row + j));
        }
        starts.sort_by(|&a, &b| distances[a].total_cmp(&distances[b]));
        starts.truncate(MOST_LEAST - 1);
        for k in next.into_iter().flatten() {
            if !starts.contains(&k) {
                starts.push(k);
            }
        }
        starts
    }

    /// The place `at` along an axis, and those next to it.
    fn around(&self, axis: usize, at: usize) -> [usize; 3] {
        let last = self.counts[axis] - 1;
        let [before, after] = if self.closed[axis] {
            [if at == 0 { last } else { at - 1 }, if at == last { 0 } else { at + 1 }]
        } else {
            [at.saturating_sub(1), (at + 1).min(last)]
        };
        [at, before, after]
    }

    /// Whether no seed around the one at `us[0]` and `j` is nearer. `us`: its place along u and those next to it.
    fn is_least(&self, distances: &[f64], us: [usize; 3], j: usize) -> bool {
        let row = self.counts[1];
        let here = distances[us[0] * row + j];
        let vs = self.around(1, j);
        here.is_finite() && us.iter().all(|&i| vs.iter().all(|&j| here <= distances[i * row + j]))
    }
}

#[cfg(test)]
mod tests {
    use crate::model::{NurbsSurface, Surface};
    use crate::prepare::uv::projector::Projector;
    use glam::{DVec2, DVec3};
    use std::f64::consts::FRAC_PI_4;

    /// A band along a helix of radius 4 and pitch 0.5, which leaves a gap of 0.05 to the next turn.
    fn band(turns: usize) -> Surface {
        let along = |k: usize| {
            let angle = k as f64 * FRAC_PI_4;
            DVec3::new(4.0 * angle.cos(), 4.0 * angle.sin(), k as f64 / 16.0)
        };
        let count = 8 * turns + 1;
        let points = [0.0, 0.45].iter().flat_map(|&up| (0..count).map(move |k| along(k) + DVec3::Z * up)).collect();
        let last = (count - 3) as f64;
        let inner = (1..count - 3).map(|k| k as f64);
        let knots_v = [0.0; 4].into_iter().chain(inner).chain([last; 4]).collect();
        let knots_u = vec![0.0, 0.0, 1.0, 1.0];
        Surface::Nurbs(NurbsSurface { degree_u: 1, degree_v: 3, knots_u, knots_v, points, weights: Vec::new() })
    }

    #[test]
    fn a_point_is_found_on_its_own_turn_of_a_spring() {
        for turns in [4, 12, 30, 300] {
            let band = band(turns);
            let [(_, _), (_, end)] = band.natural_domain();
            let projector = Projector::new(&band, 1e-7);
            for (u, v) in [(1.0, 0.0), (0.0, end), (1.0, 0.37 * end), (0.0, 0.71 * end)] {
                let p = band.point(u, v);
                let found = projector.project(p, None);
                assert!(band.point(found.x, found.y).distance(p) < 1e-6, "{turns} turns: {found} instead of {u}, {v}");
            }
        }
    }

    #[test]
    fn points_off_a_spring_do_not_end_searches_for_those_on_another_turn() {
        let band = band(4);
        let projector = Projector::new(&band, 1e-7);
        let [_, (_, end)] = band.natural_domain();
        for k in 0..20 {
            let [u, v] = [0.5, end * (0.3 + 0.01 * f64::from(k))];
            let [point, du, dv] = band.tangents(u, v);
            let off = point + du.cross(dv).normalize() * 1e-3;
            let found = projector.project(off, Some(DVec2::new(u, v)));
            assert!(band.point(found.x, found.y).distance(off) < 1.1e-3, "{found} instead of {u}, {v}");
        }
        assert_eq!(projector.vain.get(), 8);
        // The next edge: no search at the same distance, and one from another turn.
        projector.vain.set(0);
        let [point, du, dv] = band.tangents(0.5, 0.4 * end);
        projector.project(point + du.cross(dv).normalize() * 1e-3, Some(DVec2::new(0.5, 0.4 * end)));
        assert_eq!((projector.vain.get(), projector.vain_of_face.get().0), (1, 8));
        let [p, next_turn] = [0.4, 0.65].map(|share| share * end);
        let p = band.point(0.5, p);
        let found = projector.project(p, Some(DVec2::new(0.5, next_turn)));
        assert!(band.point(found.x, found.y).distance(p) < 1e-6, "{found}");
    }
}
