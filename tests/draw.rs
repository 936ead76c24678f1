//! Records of tiles against the tiles themselves, and the diagrams drawn from them.
#![cfg(feature = "svg")]

mod common;
#[path = "sequence/random.rs"]
mod random;

use common::prepared;
use glam::DVec2;
use random::SplitMix;
use std::collections::BTreeSet;
use trimtess::draw::{TileView, tile};
use trimtess::frame::internals::{Scratch, TileRecord, record_tile, tessellate_tile};
use trimtess::frame::{Rung, Tolerance, plan};
use trimtess::mesh::MeshLists;
use trimtess::model::{FreeTrims, Model, TrimCurve, TrimRule, shapes};

/// Records of all tiles of a model, each checked against the tile as frames make it.
fn records(model: Model, chord: f64) -> Vec<TileRecord> {
    let prepared = prepared(model);
    let plan = plan(&prepared, &Tolerance { chord, angle: 0.5, max_edge: None });
    let mut scratch = Scratch::default();
    let all = prepared.tiles().map(|(part, id, _)| {
        let record = record_tile(&prepared, &plan, part, id);
        let again = tessellate_tile(&prepared, &plan, (part, id), MeshLists::ALL, &mut scratch);
        assert_eq!((&record.outcome.mesh, record.outcome.rung), (&again.mesh, again.rung));
        check(&record);
        record
    });
    all.collect()
}

/// Asserts what holds for every record.
fn check(record: &TileRecord) {
    let (trim, mesh) = (&record.trim, &record.outcome.mesh);
    assert_eq!(record.places.len(), mesh.positions.len());
    let tessellants = *record.loop_starts.last().expect("an end") as usize;
    assert_eq!(trim.cell_of.len(), tessellants);
    let corner = |[i, j]: [u32; 2]| DVec2::new(f64::from(i), f64::from(j));
    for crossing in &trim.crossings {
        assert!(crossing.segment.contains(&crossing.snap), "{crossing:?}");
        let [from, to] = crossing.cells;
        assert_eq!(from[0].abs_diff(to[0]) + from[1].abs_diff(to[1]), 1, "{crossing:?}");
        let line = corner(from).max(corner(to));
        assert!((crossing.at - line).abs().min_element() <= 1e-9, "{crossing:?}");
    }
    if !record.stats.whole_tile {
        for (cell, place) in trim.cell_of.iter().zip(&record.places) {
            let Some(cell) = *cell else { continue };
            let off = (*place - corner(cell) - 0.5).abs().max_element();
            assert!(off <= 0.501, "a tessellant lies in its cell, or within the clearance of it: {off}");
        }
        let lists = [&record.full_cells, &trim.prime_cells, &trim.pseudo_cells];
        let all: BTreeSet<[u32; 2]> = lists.into_iter().flatten().copied().collect();
        assert_eq!(all.len(), lists.iter().map(|list| list.len()).sum::<usize>(), "a cell is of one kind");
        let crossed = trim.crossings.iter().flat_map(|c| c.cells);
        assert!(crossed.into_iter().all(|cell| all.contains(&cell)), "crossed cells are active");
    }
}

/// Twice the area of the triangles and of the region that the loops enclose, in cell units.
fn areas(record: &TileRecord) -> [f64; 2] {
    let place = |v: u32| record.places[v as usize];
    let turn = |t: &[u32; 3]| {
        let [a, b, c] = t.map(place);
        (b - a).perp_dot(c - a)
    };
    let triangles: f64 = record.outcome.mesh.triangles.iter().map(turn).sum();
    let of_loop = |ends: &[u32]| {
        let next = move |v: u32| if v + 1 == ends[1] { ends[0] } else { v + 1 };
        (ends[0]..ends[1]).map(|v| place(v).perp_dot(place(next(v)))).sum::<f64>()
    };
    [triangles.abs(), record.loop_starts.windows(2).map(of_loop).sum()]
}

fn sheet(curves: Vec<TrimCurve>) -> Model {
    let mut part = shapes::flower();
    part.faces[0].trims = Some(FreeTrims { rule: TrimRule::Handedness, curves });
    part.into()
}

/// Number of closed figures in the path of a class.
fn figures(svg: &str, class: &str) -> usize {
    let attribute = format!("class=\"{class}\"");
    let element = svg.split('<').find(|element| element.starts_with("path") && element.contains(&attribute));
    let data = element.and_then(|element| element.split(" d=\"").nth(1)).and_then(|data| data.split('"').next());
    data.map_or(0, |data| data.matches('z').count())
}

#[test]
fn records_match_the_tiles_that_frames_make() {
    for name in ["square", "cylinder", "cone", "sphere", "torus", "wave", "pair", "flower", "washer"] {
        for chord in [0.5, 0.05] {
            let records = records(shapes::by_name(name).expect("a shape"), chord);
            assert!(!records.is_empty(), "{name}");
            for record in records.iter().filter(|_| ["square", "wave", "flower", "washer"].contains(&name)) {
                let [triangles, loops] = areas(record);
                assert!((triangles - loops).abs() <= 1e-9 * loops, "{name}: {triangles} for {loops}");
            }
        }
    }
}

/// Stars with sharp tips close together: cells that cannot be triangulated alone are merged, and the diagram shows it.
#[test]
fn merged_cells_are_drawn() {
    let mut random = SplitMix(11);
    let mut merged = 0;
    for _ in 0..24 {
        let tips = 9 + random.below(12) as usize;
        let star: Vec<DVec2> = (0..2 * tips)
            .map(|k| {
                let angle = std::f64::consts::PI * k as f64 / tips as f64;
                let radius = if k % 2 == 0 { random.range(0.25, 0.45) } else { random.range(0.04, 0.14) };
                DVec2::splat(0.5) + DVec2::from_angle(-angle) * radius
            })
            .collect();
        let records = records(sheet(vec![TrimCurve::polygon(star)]), 0.3);
        let record = &records[0];
        let drawn = tile(record, &TileView::default());
        let cells = &record.trim.merged_cells;
        assert_eq!((drawn.merged_cells, figures(&drawn.svg, "merged")), (cells.len(), cells.len()));
        assert_eq!(record.outcome.rung == Rung::MergedCells, !cells.is_empty());
        merged += usize::from(!cells.is_empty());
        assert_eq!(figures(&drawn.svg, "triangles"), record.outcome.mesh.triangles.len());
        assert_eq!(figures(&drawn.svg, "crossings"), record.trim.crossings.len());
    }
    assert!(merged > 0, "no star needed a merge");
}

/// A lattice of more than ten thousand cells makes a file of some hundred kilobytes.
#[test]
fn fine_tiles_make_modest_files() {
    let records = records(shapes::by_name("wave").expect("a shape"), 1e-3);
    let drawn = tile(&records[0], &TileView::default());
    let [nu, nv] = drawn.cells;
    assert!(nu * nv > 10_000, "{nu} × {nv}");
    let bytes = drawn.svg.len() as f64 / f64::from(nu * nv);
    assert!(bytes < 70.0, "{bytes} bytes per cell");
    assert_eq!(figures(&drawn.svg, "triangles"), records[0].outcome.mesh.triangles.len());
    // A closer view shows less of it.
    let close = tile(&records[0], &TileView { cell: Some([nu / 2, nv / 2]), ..TileView::default() });
    assert!(close.triangles == 18 && close.svg.len() < 10_000, "{} triangles", close.triangles);
}
