//! Loops and any triangles -> the triangles to add so that the boundary is the loops.
//!
//! Let L be the loops' segments and T the triangles, as chains over positions in space. L and the boundary of T are
//! closed chains, and so is their difference R: it is a sum of closed walks. A closed walk is the boundary of the ears
//! that are cut off it one by one. With these ears added the boundary is L, whatever the loops do in (u,v) and whatever
//! T is (docs/decisions/028). On sound tiles R is zero and nothing is added; without any T the loops themselves are
//! filled.

use super::chain::EdgeSum;
use super::input::TrimInput;
use super::output::TrimOutput;
use crate::math::{Seeded, bits};
use glam::DVec3;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

/// Appends the missing triangles to `out.closing`. Points at equal `places` count as one vertex.
///
/// Cost: about 100 ns for each edge of the triangles, and O(n log n) for the n edges of R.
pub(crate) fn close(input: &TrimInput<'_>, out: &mut TrimOutput) {
    limit_layers(input, out);
    let one = Places::of(input);
    let rest = rest(input, out, &one);
    if rest.is_zero() {
        return;
    }
    for walk in rest.walks(|v| out.point(input, v)) {
        let points: Vec<DVec3> = walk.iter().map(|&v| one.place(input, out, v)).collect();
        cut_ears(&walk, &points, &mut out.closing);
    }
}

/// R: the loops minus the triangles' boundary.
fn rest(input: &TrimInput<'_>, out: &TrimOutput, one: &Places) -> EdgeSum {
    let mut rest = EdgeSum::default();
    for (a, b) in input.segments() {
        rest.add([one.at(a), one.at(b)], 1);
    }
    for &t in &out.triangles {
        rest.add_triangle(t.map(|v| one.at(v)), -1);
    }
    for &(t, times) in &out.layers {
        rest.add_triangle(t.map(|v| one.at(v)), -times);
    }
    for &cell in &out.full_cells {
        let [a, b, c, d] = input.cell_corners(cell);
        [[a, b], [b, c], [c, d], [d, a]].into_iter().for_each(|edge| rest.add(edge, -1));
    }
    rest
}

/// Layers beyond [`FEW_LAYERS`] plus this many for each segment and layered triangle are dropped and closed instead. A
/// loop that runs around n times has n layers on each of its triangles, but as many triangles as segments can fill it.
const MOST_LAYERS: u64 = 16;
const FEW_LAYERS: u64 = 1024;

/// Drops layers that exceed the limit.
fn limit_layers(input: &TrimInput<'_>, out: &mut TrimOutput) {
    let mut left = FEW_LAYERS + MOST_LAYERS * (input.points.len() + out.layers.len()) as u64;
    out.layers.retain(|&(_, times)| {
        let rest = left.checked_sub(times.unsigned_abs().into());
        left = rest.unwrap_or(left);
        rest.is_some()
    });
}

/// Finds tessellants at the same place.
pub(super) struct Places {
    /// By tessellant, the first one at its place; empty if no places are given.
    first: Vec<u32>,
}

impl Places {
    pub(super) fn of(input: &TrimInput<'_>) -> Self {
        let mut known: HashMap<[u64; 3], u32, Seeded> = HashMap::default();
        let first = (0..).zip(input.places).map(|(v, &p)| *known.entry(bits::of_point(p)).or_insert(v)).collect();
        Self { first }
    }

    pub(super) fn at(&self, v: u32) -> u32 {
        self.first.get(v as usize).copied().unwrap_or(v)
    }

    /// Position of a vertex, to choose good ears. Vertices without a place are in cell units, which is good enough for
    /// that.
    fn place(&self, input: &TrimInput<'_>, out: &TrimOutput, v: u32) -> DVec3 {
        input.places.get(v as usize).copied().unwrap_or_else(|| out.point(input, v).extend(0.0))
    }
}

/// Triangulates a closed polygon in space by cutting ears, the one with the shortest third side first.
///
/// Appends n - 2 triangles, none with a repeated vertex if the polygon's vertices are distinct. O(n log n).
fn cut_ears(ids: &[u32], points: &[DVec3], out: &mut Vec<[u32; 3]>) {
    let n = ids.len();
    let mut next: Vec<usize> = (1..n).chain([0]).collect();
    let mut prev: Vec<usize> = std::iter::once(n - 1).chain(0..n - 1).collect();
    // An ear is valid as long as its corner has the neighbours it was measured with.
    let ear = |a: usize, b: usize, c: usize| {
        let length = points[a].distance_squared(points[c]);
        // Positive floats compare as their bits do; NaN comes last.
        Reverse((length.to_bits() & (u64::MAX >> 1), b, a, c))
    };
    let mut ears: BinaryHeap<_> = (0..n).map(|b| ear(prev[b], b, next[b])).collect();
    let mut left = n;
    while left > 2 {
        let Some(Reverse((_, b, a, c))) = ears.pop() else { return };
        if (prev[b], next[b]) != (a, c) {
            continue;
        }
        out.push([ids[a], ids[b], ids[c]]);
        (next[a], prev[c]) = (c, a);
        // Removes the corner: no ear was measured with it as its own neighbour.
        (prev[b], next[b]) = (b, b);
        left -= 1;
        if left > 2 {
            ears.push(ear(prev[a], a, c));
            ears.push(ear(a, c, next[c]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn ears_have_the_boundary_of_the_polygon() {
        for n in 2..40_u32 {
            let points: Vec<DVec3> =
                (0..n).map(|k| DVec2::from_angle(f64::from(k * k)).extend(f64::from(k % 5))).collect();
            let ids: Vec<u32> = (0..n).map(|k| 7 * k).collect();
            let mut triangles = Vec::new();
            cut_ears(&ids, &points, &mut triangles);
            assert_eq!(triangles.len(), n as usize - 2);
            let mut chain = EdgeSum::default();
            triangles.iter().for_each(|&t| chain.add_triangle(t, 1));
            (0..n).for_each(|k| chain.add([7 * k, 7 * ((k + 1) % n)], -1));
            assert!(chain.is_zero());
        }
    }

    #[test]
    fn loops_without_triangles_are_filled_and_cancelled_ones_are_not() {
        // A square, and a slit: two tessellants at two places, and two more at the same places in reverse.
        let points = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y, DVec2::ZERO, DVec2::X, DVec2::X, DVec2::ZERO];
        let places: Vec<DVec3> = points.iter().map(|p| p.extend(1.0)).collect();
        let mut out = TrimOutput::default();
        for (loop_starts, wanted) in [(&[0, 4][..], 2), (&[0, 4, 8], 2), (&[0, 0, 2], 0)] {
            let last = loop_starts[loop_starts.len() - 1] as usize;
            let input = TrimInput { cells: (1, 1), points: &points[..last], loop_starts, places: &places[..last] };
            out.clear();
            close(&input, &mut out);
            assert_eq!(out.closing.len(), wanted, "{loop_starts:?}");
        }
    }
}
