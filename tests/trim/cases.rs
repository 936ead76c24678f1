//! Tiles with one difficulty each. Each is also run rotated and mirrored: eight tiles per case.

use std::f64::consts::TAU;

use glam::DVec2;
use trimtess::frame::internals::trim::{
    TrimInput, TrimInputError, TrimOutcome, TrimOutput, TrimScratch, reference, trim_tile,
};

use crate::checker::{Tile, check, check_boundary, check_cover, min_angles};

fn polygon(points: &[(f64, f64)]) -> Vec<DVec2> {
    points.iter().map(|&(x, y)| DVec2::new(x, y)).collect()
}

/// A regular polygon; clockwise (a hole) if `turns` is -1.
fn round(centre: (f64, f64), radius: f64, count: u32, turns: f64) -> Vec<DVec2> {
    let point = |k| DVec2::from_angle(turns * TAU * f64::from(k) / f64::from(count)) * radius;
    (0..count).map(|k| DVec2::new(centre.0, centre.1) + point(k)).collect()
}

/// An axis-parallel rectangle as a hole.
fn rectangle(low: (f64, f64), high: (f64, f64)) -> Vec<DVec2> {
    polygon(&[low, (low.0, high.1), high, (high.0, low.1)])
}

fn reversed(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.reverse();
    points
}

/// The tile's border with `steps` segments per side, counter-clockwise.
pub(crate) fn border(cells: (u32, u32), steps: u32) -> Vec<DVec2> {
    let (w, h) = (f64::from(cells.0), f64::from(cells.1));
    let corners = [DVec2::ZERO, DVec2::new(w, 0.0), DVec2::new(w, h), DVec2::new(0.0, h)];
    let side = |k: usize| {
        let (a, b) = (corners[k], corners[(k + 1) % 4]);
        (0..steps).map(move |s| a + (b - a) * (f64::from(s) / f64::from(steps)))
    };
    (0..4).flat_map(side).collect()
}

/// The tile rotated by 90 degrees.
fn rotated(tile: &Tile) -> Tile {
    let height = f64::from(tile.cells.1);
    Tile {
        cells: (tile.cells.1, tile.cells.0),
        points: tile.points.iter().map(|p| DVec2::new(height - p.y, p.x)).collect(),
        loop_starts: tile.loop_starts.clone(),
        places: tile.places.clone(),
    }
}

/// The tile mirrored in x, its loops reversed so that they keep the same side.
fn mirrored(tile: &Tile) -> Tile {
    let width = f64::from(tile.cells.0);
    let loops: Vec<Vec<DVec2>> = tile
        .loop_starts
        .windows(2)
        .map(|w| &tile.points[w[0] as usize..w[1] as usize])
        .map(|l| l.iter().rev().map(|p| DVec2::new(width - p.x, p.y)).collect())
        .collect();
    Tile::new(tile.cells, &loops)
}

fn images(tile: &Tile) -> Vec<Tile> {
    let mut images = vec![tile.clone(), mirrored(tile)];
    for k in 0..6 {
        images.push(rotated(&images[k]));
    }
    images
}

/// Triangulates a tile and its images, each of which `judge` accepts. Returns the result of the tile itself.
fn triangulated(
    cells: (u32, u32),
    loops: &[Vec<DVec2>],
    judge: impl Fn(&Tile, &TrimOutput) -> Result<(), String>,
) -> TrimOutput {
    let triangulate = |tile: &Tile| {
        let mut out = TrimOutput::default();
        let outcome = trim_tile(&tile.input(), &mut TrimScratch::default(), &mut out).expect("valid input");
        assert_eq!(outcome, out.stats.outcome);
        if let Err(fault) = judge(tile, &out) {
            panic!("{fault}\n{:?}\n{tile:?}", out.stats);
        }
        out
    };
    images(&Tile::new(cells, loops)).iter().map(triangulate).collect::<Vec<_>>().swap_remove(0)
}

/// Checks the tile, its images and the reference with the exact checker.
fn assert_exact(cells: (u32, u32), loops: &[Vec<DVec2>]) -> TrimOutput {
    triangulated(cells, loops, |tile, out| {
        let mut plain = TrimOutput::default();
        reference::trim_tile_reference(&tile.input(), &mut plain).expect("valid input");
        [out, &plain].into_iter().try_for_each(|result| {
            assert!(!matches!(result.stats.outcome, TrimOutcome::Repaired { .. }), "{:?}", result.stats);
            check(&tile.input(), result, true).and(check_boundary(&tile.input(), result))
        })
    })
}

/// Checks loops that are not simple.
fn assert_repaired(cells: (u32, u32), loops: &[Vec<DVec2>]) -> TrimOutput {
    triangulated(cells, loops, |tile, out| {
        assert!(matches!(out.stats.outcome, TrimOutcome::Repaired { .. }), "{:?}", out.stats);
        check(&tile.input(), out, false)?;
        check_cover(&tile.input(), out)?;
        check_boundary(&tile.input(), out)
    })
}

/// Checks only the boundary of the result, for arbitrary loops.
fn assert_closed(cells: (u32, u32), loops: &[Vec<DVec2>]) -> TrimOutput {
    triangulated(cells, loops, |tile, out| check_boundary(&tile.input(), out))
}

fn assert_in_border(cells: (u32, u32), steps: u32, hole: Vec<DVec2>) -> TrimOutput {
    assert_exact(cells, &[border(cells, steps), hole])
}

// -- degenerate cases of the cell scheme

#[test]
fn case_01_tessellant_on_a_line_or_a_corner() {
    assert_in_border((5, 5), 5, polygon(&[(2.0, 1.5), (1.5, 2.4), (2.6, 2.7)]));
    assert_in_border((5, 5), 5, polygon(&[(2.0, 2.0), (1.6, 2.7), (2.8, 2.5)]));
    assert_in_border((5, 5), 5, polygon(&[(2.0, 1.0), (1.0, 3.0), (3.0, 4.0), (4.0, 2.0)]));
}

#[test]
fn case_02_segments_along_a_line() {
    assert_in_border((6, 6), 6, rectangle((2.0, 2.0), (4.0, 4.0)));
    assert_in_border((6, 6), 3, rectangle((1.5, 2.0), (3.25, 4.0)));
    assert_in_border(
        (6, 6),
        4,
        polygon(&[(1.0, 2.0), (1.3, 3.5), (4.7, 3.5), (4.0, 2.0), (3.25, 2.0), (2.0, 2.0), (1.5, 2.0)]),
    );
}

#[test]
fn case_03_segments_through_corners() {
    assert_in_border((6, 6), 6, polygon(&[(1.5, 3.0), (3.0, 4.5), (4.5, 3.0), (3.0, 1.5)]));
    assert_in_border((6, 6), 2, polygon(&[(0.5, 0.5), (1.0, 5.5), (5.5, 5.5)]));
}

#[test]
fn case_04_segments_over_many_cells() {
    assert_in_border((9, 7), 1, polygon(&[(0.3, 0.4), (8.4, 6.3), (8.7, 5.9)]));
    assert_in_border((9, 7), 1, polygon(&[(1.2, 3.1), (7.7, 3.9), (1.3, 3.3), (7.5, 4.6), (8.2, 3.8)]));
}

#[test]
fn case_05_several_passes_in_a_cell() {
    let comb = polygon(&[
        (1.1, 0.5),
        (1.1, 4.5),
        (1.9, 4.5),
        (1.9, 0.5),
        (1.7, 0.5),
        (1.7, 4.2),
        (1.5, 4.2),
        (1.5, 0.6),
        (1.3, 0.6),
        (1.3, 4.3),
        (1.2, 4.3),
        (1.2, 0.5),
    ]);
    assert_in_border((3, 5), 5, comb);
    let cells = (3, 3);
    assert_exact(cells, &[border(cells, 3), rectangle((0.4, 1.2), (2.7, 1.4)), rectangle((0.5, 1.5), (2.6, 1.6))]);
}

#[test]
fn case_06_in_and_out_through_one_edge() {
    assert_in_border((4, 4), 4, polygon(&[(1.5, 0.6), (1.2, 2.05), (1.8, 2.1)]));
    assert_in_border((4, 4), 4, polygon(&[(1.2, 1.7), (1.5, 2.001), (1.8, 1.7)]));
}

#[test]
fn case_07_loops_inside_one_cell() {
    for cells in [(1, 1), (4, 4)] {
        let (hole, island) = (round((0.5, 0.5), 0.3, 12, -1.0), round((0.5, 0.5), 0.2, 9, 1.0));
        let pit = round((0.5, 0.5), 0.1, 5, -1.0);
        assert_exact(cells, &[border(cells, 3), hole.clone()]);
        assert_exact(cells, &[border(cells, 3), hole.clone(), island.clone()]);
        assert_exact(cells, &[border(cells, 3), hole, island, pit]);
    }
    assert_exact((4, 4), &[border((4, 4), 4), round((2.5, 2.5), 0.3, 12, -1.0)]);
    assert_exact((4, 4), &[round((2.5, 2.5), 0.3, 12, 1.0)]);
}

#[test]
fn holes_in_a_cell_are_swept_with_it() {
    for (cells, at) in [((1, 1), 0.0), ((5, 5), 2.0)] {
        let mut loops = vec![border(cells, 3)];
        for (x, y) in [(0.25, 0.3), (0.7, 0.25), (0.3, 0.7), (0.72, 0.7), (0.5, 0.5)] {
            loops.push(round((at + x, at + y), 0.1, 6, -1.0));
            let out = assert_exact(cells, &loops);
            assert_eq!(out.stats.outcome, TrimOutcome::Certified, "{:?}", out.stats);
        }
    }
}

#[test]
fn case_08_pseudo_active_cells() {
    // The thin hole cuts corners off cells that have no tessellant and no kept corner.
    assert_in_border((5, 5), 5, polygon(&[(0.5, 0.9), (0.9, 1.3), (4.3, 4.7), (4.7, 4.3), (1.3, 0.9)]));
}

#[test]
fn case_09_ends_on_the_border() {
    // From border to border, from a patch corner, and touching the border with one tessellant.
    assert_exact((4, 3), &[polygon(&[(0.0, 0.0), (2.5, 0.0), (2.2, 1.4), (1.6, 3.0), (0.0, 3.0)])]);
    assert_exact((4, 3), &[polygon(&[(0.0, 0.0), (4.0, 0.0), (4.0, 3.0)])]);
    assert_exact((4, 4), &[polygon(&[(2.0, 0.0), (4.0, 2.0), (2.0, 4.0), (0.0, 2.0)])]);
    assert_exact((4, 4), &[polygon(&[(0.5, 0.0), (1.5, 1.5), (2.2, 0.0), (3.2, 1.6), (2.0, 3.9), (0.1, 2.0)])]);
}

#[test]
fn case_10_cusps() {
    assert_in_border((3, 3), 3, polygon(&[(0.4, 0.5), (2.5, 1.5 + 1e-9), (2.5, 1.5)]));
    assert_in_border((3, 3), 3, polygon(&[(1.5 + 1e-7, 1.5), (2.6, 0.6), (0.4, 0.5), (1.5, 1.5)]));
}

#[test]
fn case_11_snapped_polygons_that_are_not_simple() {
    // Two walls of a narrow gap run along each other: the nearer ends change sides.
    assert_in_border((6, 4), 1, polygon(&[(0.5, 1.95), (0.5, 3.0), (5.5, 3.05), (5.4, 1.9), (5.3, 2.95), (0.7, 2.9)]));
    assert_in_border((6, 4), 1, polygon(&[(0.6, 0.9), (5.2, 3.1), (5.3, 3.05), (0.7, 0.8)]));
}

#[test]
fn case_12_merged_polygons_with_holes() {
    let mut loops = vec![border((4, 4), 4), polygon(&[(0.5, 0.5), (0.5, 3.5), (3.5, 3.5), (3.5, 0.5)])];
    loops.push(reversed(polygon(&[(0.6, 0.6), (0.6, 3.4), (3.4, 3.4), (3.4, 0.6)])));
    loops.push(round((2.02, 2.01), 0.05, 6, -1.0));
    assert_exact((4, 4), &loops);
}

#[test]
fn case_13_segments_with_common_ends_and_crossings() {
    // Zigzags whose segments cross each lattice line within rounding of each other.
    let mut zigzag = Vec::new();
    for k in 0..7 {
        let shift = 1e-12 * f64::from(k);
        zigzag.extend([DVec2::new(1.2 + shift, 2.5), DVec2::new(1.5 + shift, 0.5)]);
    }
    zigzag.extend(polygon(&[(2.5, 1.5), (1.3, 2.9)]));
    assert_in_border((4, 4), 4, reversed(zigzag));
    assert_in_border((4, 4), 4, polygon(&[(1.5, 0.5), (1.2, 2.5), (1.5, 0.5 + 1e-12), (1.8, 2.5)]));
}

#[test]
fn case_14_trim_in_a_border_cell() {
    assert_in_border((4, 4), 7, round((0.5, 0.5), 0.45, 16, -1.0));
    assert_in_border((4, 4), 9, polygon(&[(0.1, 0.2), (0.2, 3.8), (0.9, 3.9), (0.3, 0.1)]));
}

#[test]
fn case_15_all_corners_trimmed() {
    // A kept strip through the middle of a row of cells.
    assert_exact((5, 3), &[polygon(&[(0.2, 1.3), (4.8, 1.4), (4.8, 1.6), (0.2, 1.7)])]);
    assert_exact(
        (5, 5),
        &[polygon(&[(2.5, 0.4), (2.6, 2.4), (4.6, 2.5), (2.6, 2.6), (2.5, 4.6), (2.4, 2.6), (0.4, 2.5), (2.4, 2.4)])],
    );
}

#[test]
fn case_16_loops_that_touch() {
    // At a tessellant of both loops: nothing is split.
    let (left, right) =
        (polygon(&[(1.0, 1.0), (1.2, 2.8), (2.5, 2.0)]), polygon(&[(2.5, 2.0), (3.8, 2.8), (3.9, 1.2)]));
    assert_exact((5, 4), &[border((5, 4), 5), left.clone(), right.clone()]);
    assert_exact(
        (1, 1),
        &[border((5, 4), 5), left, right].map(|l| l.iter().map(|p| *p / DVec2::new(5.0, 4.0)).collect()),
    );
    // In the middle of a segment: it must be split there.
    let out = assert_repaired(
        (4, 4),
        &[border((4, 4), 4), rectangle((1.0, 1.0), (2.0, 3.0)), polygon(&[(2.0, 2.0), (3.0, 3.0), (3.0, 1.0)])],
    );
    assert_eq!(out.stats.outcome, TrimOutcome::Repaired { split: 1 });
    assert!(out.extra_points.is_empty());
}

#[test]
fn case_17_poles_and_seams() {
    // A pole is a border side with as many tessellants as its other side; a seam has the same tessellants on both
    // sides.
    let mut outer = border((6, 3), 1);
    outer.splice(1..1, (1..40).map(|k| DVec2::new(6.0, 3.0 * f64::from(k) / 40.0)).map(|p| DVec2::new(p.y * 2.0, 0.0)));
    assert_exact((6, 3), &[outer]);
}

#[test]
fn case_18_one_row_or_one_cell() {
    for cells in [(1, 1), (1, 6), (6, 1)] {
        for steps in [1, 2, 5, 30] {
            assert_exact(cells, &[border(cells, steps)]);
            assert_exact(cells, &[border(cells, steps), round((0.5, 0.5), 0.4, 20, -1.0)]);
        }
    }
    assert_exact((6, 1), &[border((6, 1), 2), rectangle((0.3, 0.2), (5.6, 0.7))]);
}

// -- repeated points and slits

#[test]
fn rows_have_more_cells_than_words_have_bits() {
    // Holes over the end of a word, and in a last word that is not full.
    let hole = |x, radius, count| round((x, 1.6), radius, count, -1.0);
    assert_exact((130, 3), &[border((130, 3), 4), hole(64.3, 1.2, 23), hole(127.6, 1.1, 17)]);
}

#[test]
fn repeated_points_vanish() {
    let mut hole = round((2.0, 2.0), 1.1, 9, -1.0);
    let twice: Vec<DVec2> = hole.iter().flat_map(|&p| [p, p]).collect();
    let (plain, doubled) = (assert_in_border((4, 4), 4, hole.clone()), assert_in_border((4, 4), 4, twice));
    assert_eq!(plain.triangles.len(), doubled.triangles.len());
    hole.push(hole[0]);
    assert_eq!(assert_in_border((4, 4), 4, hole).triangles.len(), plain.triangles.len());
    let point = vec![DVec2::new(1.7, 1.9); 3];
    let out = assert_exact((4, 4), &[border((4, 4), 4), point]);
    assert_eq!(out.stats.outcome, TrimOutcome::Certified);
}

#[test]
fn collinear_runs_along_the_border() {
    for cells in [(1, 1), (3, 2)] {
        assert_exact(cells, &[border(cells, 17)]);
        let (w, h) = (f64::from(cells.0), f64::from(cells.1));
        assert_exact(
            cells,
            &[polygon(&[(0.0, 0.0), (0.1 * w, 0.0), (0.11 * w, 0.0), (0.9 * w, 0.0), (w, 0.0), (w, h), (0.5 * w, h)])],
        );
    }
}

/// The border with a slit from (x, 0) to the point and back.
fn border_with_slit(cells: (u32, u32), x: f64, tip: (f64, f64)) -> Vec<DVec2> {
    let mut outer = border(cells, 1);
    outer.splice(1..1, polygon(&[(x, 0.0), tip, (x, 0.0)]));
    outer
}

#[test]
fn slits_keep_both_sides() {
    for cells in [(1, 1), (3, 4)] {
        let size = DVec2::new(f64::from(cells.0), f64::from(cells.1));
        let tip = size * DVec2::new(0.45, 0.7);
        let out = assert_exact(cells, &[border_with_slit(cells, 0.4 * size.x, (tip.x, tip.y))]);
        // In the slit's root, point 1 lies left of the way in and point 3 left of the way back.
        for edge in [[1, 2], [2, 3]] {
            let used = out.triangles.iter().any(|t| (0..3).any(|k| [t[k], t[(k + 1) % 3]] == edge));
            assert!(used, "{edge:?} in {cells:?}");
        }
    }
}

#[test]
fn slit_of_several_segments() {
    let way: Vec<DVec2> = (0..=10).map(|k| DVec2::new(1.4 + 0.05 * f64::from(k), 0.3 * f64::from(k))).collect();
    let mut outer = border((4, 4), 4);
    let back: Vec<DVec2> = way.iter().rev().skip(1).copied().collect();
    let at = outer.iter().position(|p| p.x > 1.4).expect("the border reaches the slit");
    outer.splice(at..at, way.into_iter().chain(back));
    assert_exact((4, 4), &[outer]);
}

#[test]
fn slit_as_a_loop_of_two() {
    assert_exact((1, 1), &[border((1, 1), 2), polygon(&[(0.3, 0.4), (0.6, 0.7)])]);
    assert_exact((4, 4), &[border((4, 4), 2), polygon(&[(0.7, 0.9), (3.3, 2.6)])]);
}

#[test]
fn hole_joined_to_the_border_by_a_bridge() {
    for cells in [(1, 1), (5, 5)] {
        let scale = f64::from(cells.0);
        let mut outer = border(cells, 1);
        let mut key = vec![DVec2::new(0.5, 0.0)];
        let hole = round((0.5, 0.5), 0.25, 12, -1.0);
        // From the hole's lowest point around and back to it.
        key.extend((0..=12).map(|k| hole[(3 + k) % 12]));
        key.push(DVec2::new(0.5, 0.0));
        outer.splice(1..1, key.iter().map(|p| *p * scale));
        assert_exact(cells, &[outer]);
    }
}

#[test]
fn loops_that_touch_at_tessellants() {
    for (cells, scale) in [((1, 1), 0.2), ((5, 5), 1.0)] {
        let scaled = |points: &[(f64, f64)]| -> Vec<DVec2> { polygon(points).iter().map(|p| *p * scale).collect() };
        let outer = || -> Vec<DVec2> { border((5, 5), 5).iter().map(|p| *p * scale).collect() };
        // A hole that touches the border at a border tessellant.
        assert_exact(cells, &[outer(), scaled(&[(2.0, 0.0), (1.5, 1.5), (2.5, 1.6)])]);
        // Two holes in a ring: the region between them is connected at two points only.
        assert_exact(
            cells,
            &[
                outer(),
                scaled(&[(1.0, 2.0), (2.5, 4.0), (4.0, 2.0), (2.5, 3.0)]),
                scaled(&[(1.0, 2.0), (2.5, 1.5), (4.0, 2.0), (2.5, 1.0)]),
            ],
        );
        // One loop that touches itself.
        assert_exact(
            cells,
            &[outer(), scaled(&[(2.5, 2.5), (1.0, 2.0), (1.0, 3.0), (2.5, 2.5), (4.0, 3.0), (4.0, 2.0)])],
        );
    }
}

// -- loops that are not simple

#[test]
fn crossing_loops_are_split_where_they_meet() {
    let out = assert_repaired(
        (4, 4),
        &[border((4, 4), 4), rectangle((0.7, 0.7), (2.3, 2.3)), rectangle((1.7, 1.6), (3.3, 3.2))],
    );
    assert_eq!(out.stats.outcome, TrimOutcome::Repaired { split: 4 });
    assert_eq!(out.extra_points.len(), 2);
}

#[test]
fn figure_of_eight_has_one_lobe_reversed() {
    let out = assert_repaired((3, 3), &[polygon(&[(0.5, 0.5), (2.5, 2.5), (2.5, 0.5), (0.5, 2.5)])]);
    assert_eq!(out.extra_points.len(), 1);
    assert!(!out.triangles.is_empty());
    assert!(!out.layers.is_empty() && out.layers.iter().all(|&(_, times)| times == -1));
    // Two triangles join the split segments to the unsplit ones of the neighbours.
    assert_eq!(out.closing.len(), 2);
}

#[test]
fn overlapping_loops_cancel_or_add() {
    let twice = assert_repaired((3, 3), &[border((3, 3), 3), border((3, 3), 3)]);
    assert!(twice.layers.iter().all(|&(_, times)| times == 1) && twice.closing.is_empty());
    // A hole that leaves through the border's side, along it.
    assert_repaired((3, 3), &[border((3, 3), 1), rectangle((1.0, 0.0), (2.0, 1.5))]);
    // A loop and its reverse leave nothing; a slit traversed twice vanishes.
    for loops in [[border((3, 3), 3), reversed(border((3, 3), 3))], [border((1, 1), 3), reversed(border((1, 1), 3))]] {
        let out = assert_exact((3, 3), &loops);
        assert!(out.triangles.is_empty() && out.full_cells.is_empty());
    }
    let slit = polygon(&[(1.5, 0.0), (1.2, 1.7), (1.5, 0.0), (1.2, 1.7), (1.5, 0.0)]);
    let outer: Vec<DVec2> = [&border((3, 3), 1)[..1], &slit, &border((3, 3), 1)[1..]].concat();
    assert_closed((3, 3), &[outer]);
    assert_repaired((1, 1), &[border((1, 1), 3), reversed(border((1, 1), 2))]);
}

#[test]
fn loops_that_run_the_wrong_way_are_reversed() {
    let out = assert_repaired((3, 3), &[reversed(border((3, 3), 2))]);
    assert!(out.triangles.is_empty() && out.full_cells.is_empty() && out.closing.is_empty());
    assert!(!out.layers.is_empty() && out.layers.iter().all(|&(_, times)| times == -1));
}

#[test]
fn flat_loops_cancel_or_are_closed() {
    for cells in [(1, 1), (3, 3)] {
        let scale = f64::from(cells.0);
        let line: Vec<DVec2> = polygon(&[(0.1, 0.2), (0.9, 0.2), (0.5, 0.2)]).iter().map(|p| *p * scale).collect();
        let out = assert_closed(cells, &[line]);
        assert!(out.triangles.is_empty() && out.full_cells.is_empty());
        assert_eq!(out.closing.len(), 1, "in (u,v) it is a line, its neighbours have three edges there");
        let there_and_back = polygon(&[(0.1 * scale, 0.2), (0.9 * scale, 0.2)]);
        let out = assert_closed(cells, &[there_and_back]);
        assert!(out.closing.is_empty(), "its edges cancel");
    }
}

#[test]
fn points_in_one_place_of_the_plane_and_two_in_space_are_joined() {
    // Two tessellants with the same parameters: a point clamped to the border, or a pole that the file states.
    let mut hole = round((2.0, 2.0), 1.1, 9, -1.0);
    hole.insert(3, hole[2]);
    for cells in [(4, 4), (1, 1)] {
        let scale =
            |l: &[DVec2]| l.iter().map(|p| *p * DVec2::new(f64::from(cells.0), f64::from(cells.1)) / 4.0).collect();
        let mut tile = Tile::new(cells, &[scale(&border((4, 4), 4)), scale(&hole)]);
        tile.places[16 + 3].z = 1.0;
        let mut out = TrimOutput::default();
        trim_tile(&tile.input(), &mut TrimScratch::default(), &mut out).expect("valid input");
        assert_eq!(check_boundary(&tile.input(), &out), Ok(()));
        assert_eq!(out.closing.len(), 1);
        // Reversed, there is nothing to join.
        tile.places[16 + 3].z = 0.0;
        trim_tile(&tile.input(), &mut TrimScratch::default(), &mut out).expect("valid input");
        assert!(out.closing.is_empty() && check_boundary(&tile.input(), &out).is_ok());
    }
}

// -- quality

/// Smallest angles of the trim triangles in degrees, ascending.
fn angles(tile: &Tile, out: &TrimOutput) -> Vec<f64> {
    let mut angles = min_angles(&tile.input(), out);
    angles.sort_by(f64::total_cmp);
    angles
}

#[test]
fn angles_come_close_to_delaunay() {
    for segment in [1.0, 0.5, 0.2, 0.1] {
        let hole = |x, y, r: f64| round((x, y), r, (TAU * r / segment) as u32, -1.0);
        let plate = [border((32, 32), (32.0 / segment) as u32), hole(9.3, 8.1, 5.0), hole(22.7, 14.4, 6.5)];
        let disc = [round((16.1, 15.7), 13.0, (TAU * 13.0 / segment) as u32, 1.0), hole(15.2, 17.3, 5.0)];
        for tile in [Tile::new((32, 32), &plate), Tile::new((32, 32), &disc)] {
            let (mut out, mut plain) = (TrimOutput::default(), TrimOutput::default());
            trim_tile(&tile.input(), &mut TrimScratch::default(), &mut out).expect("valid input");
            reference::trim_tile_reference(&tile.input(), &mut plain).expect("valid input");
            let (ours, best) = (angles(&tile, &out), angles(&tile, &plain));
            let at = |angles: &[f64], share: f64| angles[(share * (angles.len() - 1) as f64) as usize];
            // Edges may not leave their cell. This costs the thinnest triangles up to 0.6 of their angle, most
            // triangles nothing.
            for (share, least) in [(0.0, 0.4), (0.1, 0.9), (0.5, 0.95)] {
                let (ours, best) = (at(&ours, share), at(&best, share));
                assert!(ours >= least * best, "segments of {segment}: {ours} instead of {best} at {share}");
            }
        }
    }
}

// -- the contract

#[test]
fn nothing_in_nothing_out() {
    let mut out = TrimOutput::default();
    for loop_starts in [&[0][..], &[0, 0, 0][..]] {
        let input = TrimInput { cells: (3, 2), points: &[], loop_starts, places: &[] };
        let outcome = trim_tile(&input, &mut TrimScratch::default(), &mut out);
        assert_eq!(outcome, Ok(TrimOutcome::Certified));
        assert!(out.triangles.is_empty() && out.full_cells.is_empty());
    }
}

#[test]
fn input_outside_the_contract_is_refused() {
    let square = border((2, 2), 1);
    let refuse = |cells, points: &[DVec2], loop_starts: &[u32]| {
        let input = TrimInput { cells, points, loop_starts, places: &[] };
        trim_tile(&input, &mut TrimScratch::default(), &mut TrimOutput::default()).expect_err("refused")
    };
    for bad in [f64::NAN, f64::INFINITY, -1e-9, 2.0 + 1e-9] {
        let mut points = square.clone();
        points[2].y = bad;
        assert!(matches!(refuse((2, 2), &points, &[0, 4]), TrimInputError::PointOutside { index: 2, .. }));
    }
    assert_eq!(refuse((2, 2), &square, &[0, 3]), TrimInputError::LoopStarts { index: 2 });
    assert_eq!(refuse((2, 2), &square, &[]), TrimInputError::LoopStarts { index: 0 });
    assert_eq!(refuse((2, 2), &square, &[1, 4]), TrimInputError::LoopStarts { index: 0 });
    assert_eq!(refuse((2, 2), &square, &[0, 3, 2, 4]), TrimInputError::LoopStarts { index: 2 });
    for cells in [(0, 2), (2, 0), (70_000, 2)] {
        assert_eq!(refuse(cells, &[], &[0]), TrimInputError::Size { points: 0, cells });
    }
}

#[test]
fn scratch_forgets() {
    let small = Tile::new((3, 3), &[border((3, 3), 3), round((1.5, 1.5), 0.8, 9, -1.0)]);
    let large = Tile::new((40, 40), &[border((40, 40), 40), round((20.0, 20.0), 15.0, 90, -1.0)]);
    let mut used = TrimScratch::default();
    let (mut fresh_out, mut used_out) = (TrimOutput::default(), TrimOutput::default());
    trim_tile(&small.input(), &mut TrimScratch::default(), &mut fresh_out).expect("valid input");
    trim_tile(&large.input(), &mut used, &mut used_out).expect("valid input");
    trim_tile(&small.input(), &mut used, &mut used_out).expect("valid input");
    assert_eq!(fresh_out.triangles, used_out.triangles);
    assert_eq!(fresh_out.full_cells, used_out.full_cells);
    assert_eq!(fresh_out.stats, used_out.stats);
}
