//! Tiles with one difficulty each.

use glam::DVec2;
use trimtess::frame::trim::{TrimOutcome, TrimOutput, TrimScratch, reference, trim_tile};

use crate::checker::{Tile, check};

pub(crate) fn polygon(points: &[(f64, f64)]) -> Vec<DVec2> {
    points.iter().map(|&(x, y)| DVec2::new(x, y)).collect()
}

/// The tile's border, `steps` segments per side, counter-clockwise.
pub(crate) fn border(cells: (u32, u32), steps: u32) -> Vec<DVec2> {
    let (w, h) = (f64::from(cells.0), f64::from(cells.1));
    let corners = [DVec2::ZERO, DVec2::new(w, 0.0), DVec2::new(w, h), DVec2::new(0.0, h)];
    let side = |k: usize| {
        let (a, b) = (corners[k], corners[(k + 1) % 4]);
        (0..steps).map(move |s| a + (b - a) * (f64::from(s) / f64::from(steps)))
    };
    (0..4).flat_map(side).collect()
}

/// Runs the tile, and the reference, through the exact checker.
fn run(tile: &Tile) -> (TrimOutcome, TrimOutput) {
    let (mut out, mut plain) = (TrimOutput::default(), TrimOutput::default());
    let outcome = trim_tile(&tile.input(), &mut TrimScratch::default(), &mut out).expect("valid input");
    reference::trim_tile_reference(&tile.input(), &mut plain).expect("valid input");
    for result in [&out, &plain] {
        if let Err(fault) = check(&tile.input(), result, true) {
            panic!("{fault}\n{tile:?}");
        }
    }
    (outcome, out)
}

#[test]
fn border_alone() {
    for cells in [(1, 1), (3, 2), (7, 1)] {
        for steps in [1, 2, 5] {
            run(&Tile::new(cells, &[border(cells, steps)]));
        }
    }
}

#[test]
fn hole_over_several_cells() {
    let hole = polygon(&[(1.3, 1.2), (1.2, 2.7), (2.6, 2.9), (2.8, 1.4)]);
    let (_, out) = run(&Tile::new((5, 5), &[border((5, 5), 5), hole]));
    assert!(!out.full_cells.is_empty());
}

#[test]
fn slit_keeps_both_sides() {
    let mut outer = border((1, 1), 1);
    outer.splice(1..1, polygon(&[(0.5, 0.0), (0.5, 0.6), (0.5, 0.0)]));
    let (_, out) = run(&Tile::new((1, 1), &[outer]));
    // Left of the way in is point 1, left of the way back is point 3.
    assert!(out.triangles.iter().any(|t| (0..3).any(|k| t[k] == 1 && t[(k + 1) % 3] == 2)));
    assert!(out.triangles.iter().any(|t| (0..3).any(|k| t[k] == 2 && t[(k + 1) % 3] == 3)));
}
