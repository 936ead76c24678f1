//! Draws the figures of the documentation with the crate itself. Run it without an argument after a change to what they
//! show, or with a folder to compare (as CI does).
//!
//! ```sh
//! cargo run --features svg --example figures [FOLDER]
//! ```

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use trimtess::draw::{RegionPanel, TileView, regions, tile};
use trimtess::frame::internals::{TileRecord, record_tile};
use trimtess::frame::{self, Tolerance};
use trimtess::glam::DVec2;
use trimtess::model::{FreeTrims, Model, PartId, TileId, TrimCurve, TrimRule, shapes};
use trimtess::prepare::{self, PrepareOptions, UvDomain};

fn main() -> Result<(), Box<dyn Error>> {
    let default = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/figures");
    let folder = std::env::args_os().nth(1).map_or(default, PathBuf::from);
    fs::create_dir_all(&folder)?;
    let save = |name: &str, svg: String| fs::write(folder.join(name), svg);
    save("rules.svg", rules()?)?;
    save("open_curves.svg", open_curves()?)?;
    save("mirrored.svg", mirrored()?)?;

    let record = traced()?;
    let title = vec!["A bicubic tile with free trims, as it is triangulated".to_owned()];
    save("tile.svg", tile(&record, &TileView { title, cell: None }).svg)?;
    let cell = busiest(&record).ok_or("no cell has crossings")?;
    let title = vec!["One of its prime-active cells".to_owned()];
    let drawn = tile(&record, &TileView { title, cell: Some(cell) });
    assert!(drawn.crossings > 0 && drawn.external_points > 0 && drawn.exit_points > 0, "{drawn:?}");
    save("cell.svg", drawn.svg)?;
    println!("{}", folder.display());
    Ok(())
}

/// A panel of the unit square.
fn panel<'a>(trims: &'a FreeTrims, caption: &[&str]) -> RegionPanel<'a> {
    let domain = UvDomain::new(DVec2::ZERO, DVec2::ONE);
    let caption = caption.iter().map(|line| (*line).to_owned()).collect();
    RegionPanel { trims, domain, as_in_paper: false, caption }
}

fn circle(u: f64, v: f64, radius: f64) -> TrimCurve {
    TrimCurve::circle(DVec2::new(u, v), radius)
}

fn bezier(points: [(f64, f64); 4]) -> TrimCurve {
    TrimCurve::bezier(points.map(|(u, v)| DVec2::new(u, v)).to_vec(), Vec::new())
}

/// The same loops under the three rules.
fn rules() -> Result<String, Box<dyn Error>> {
    let curves = vec![circle(0.4, 0.55, 0.3), circle(0.62, 0.42, 0.3), circle(0.44, 0.52, 0.12).reversed()];
    let rules = [TrimRule::Handedness, TrimRule::NonZero, TrimRule::EvenOdd];
    let trims = rules.map(|rule| FreeTrims { rule, curves: curves.clone() });
    let panels = [
        panel(&trims[0], &["Handedness:", "left of all curves"]),
        panel(&trims[1], &["NonZero:", "winding number is not 0"]),
        panel(&trims[2], &["EvenOdd:", "winding number is odd"]),
    ];
    let title = ["Two counter-clockwise loops and a clockwise one; u to the right, v up".to_owned()];
    Ok(regions(&title, &panels)?)
}

/// Open curves, closed along the border of the domain around their left side.
fn open_curves() -> Result<String, Box<dyn Error>> {
    let wave = || bezier([(0.0, 0.35), (0.35, 0.95), (0.65, -0.05), (1.0, 0.6)]);
    let stroke = || bezier([(0.35, 0.0), (0.9, 0.35), (0.1, 0.65), (0.6, 1.0)]);
    let trims = [
        FreeTrims { rule: TrimRule::Handedness, curves: vec![wave()] },
        FreeTrims { rule: TrimRule::Handedness, curves: vec![wave().reversed()] },
        FreeTrims { rule: TrimRule::Handedness, curves: vec![wave(), stroke()] },
        FreeTrims { rule: TrimRule::EvenOdd, curves: vec![wave(), stroke()] },
    ];
    let panels = [
        panel(&trims[0], &["An open curve: its left is kept"]),
        panel(&trims[1], &["The same curve reversed"]),
        panel(&trims[2], &["Handedness: left of both"]),
        panel(&trims[3], &["EvenOdd: left of one of them"]),
    ];
    let title = ["Open curves: each makes a loop with the border of the domain, around its left side".to_owned()];
    Ok(regions(&title, &panels)?)
}

/// The same region in the paper's axes and in the crate's.
fn mirrored() -> Result<String, Box<dyn Error>> {
    let hook = bezier([(0.0, 0.7), (0.5, 0.9), (0.3, 0.2), (0.75, 0.0)]);
    let trims = FreeTrims { rule: TrimRule::Handedness, curves: vec![hook, circle(0.7, 0.68, 0.16).reversed()] };
    let paper = RegionPanel {
        as_in_paper: true,
        ..panel(&trims, &["In the paper: v to the right, u up;", "right of a curve is trimmed"])
    };
    let ours = panel(&trims, &["Here: u to the right, v up;", "curves reversed, left is kept"]);
    let title = ["One region, drawn twice: exchanging the axes turns every curve around".to_owned()];
    Ok(regions(&title, &[paper, ours])?)
}

/// A bicubic tile with a curved hole, a jagged one and an open cut.
fn traced() -> Result<TileRecord, Box<dyn Error>> {
    let mut part = shapes::flower();
    let jagged = [
        (0.62, 0.62),
        (0.71, 0.9),
        (0.735, 0.66),
        (0.93, 0.82),
        (0.79, 0.63),
        (0.9, 0.55),
        (0.76, 0.58),
        (0.72, 0.42),
        (0.7, 0.59),
    ];
    let jagged = TrimCurve::polygon(jagged.map(|(u, v)| DVec2::new(u, v)).to_vec());
    let cut = bezier([(0.0, 0.3), (0.45, 0.35), (0.4, 0.1), (0.7, 0.0)]).reversed();
    let curves = vec![circle(0.34, 0.62, 0.2).reversed(), jagged, cut.reversed()];
    part.faces[0].trims = Some(FreeTrims { rule: TrimRule::Handedness, curves });
    let prepared = prepare::prepare(Model::from(part), &PrepareOptions::DEFAULT)?;
    let plan = frame::plan(&prepared, &Tolerance { chord: 0.12, angle: 0.5, max_edge: None });
    let record = record_tile(&prepared, &plan, PartId::new(0), TileId(0));
    assert!(record.outcome.degradation.is_none(), "{:?}", record.outcome.degradation);
    assert!(!record.outcome.mesh.triangles.is_empty(), "the figure shows triangles");
    Ok(record)
}

/// The cell with the most crossings.
fn busiest(record: &TileRecord) -> Option<[u32; 2]> {
    let crossings = |cell: &[u32; 2]| record.trim.crossings.iter().filter(|c| c.cells.contains(cell)).count();
    let inner = |cell: &&[u32; 2]| cell.iter().all(|&k| k > 0);
    record.trim.prime_cells.iter().filter(inner).max_by_key(|cell| crossings(cell)).copied()
}
