//! What tiles cost, by what is in them: the model of `prepare::Tile::weight`, fitted to times of this machine.
//!
//! `cargo run --release --features step --example tile_costs -- FILE...` (STEP files, or builtin:NAME) makes each tile alone, on one thread,
//! for six views around each model at half a pixel of 1920 × 1080, takes the least of four times, and prints the nanoseconds for a tile,
//! a cell, a boundary tessellant, and a tessellant beyond 32 per cell that have the least relative error over all tiles; then, for
//! each file, how well these and the weights that `prepare` gives (which knows no view) go with what was measured.

use faer::Mat;
use faer::prelude::Solve;
use std::error::Error;
use std::f64::consts::FRAC_PI_6;
use std::time::Instant;
use trimtess::frame::{CameraPath, Picture, Plan, Scratch, plan_for_view, tessellate_tile};
use trimtess::import::step::{StepOptions, read_file};
use trimtess::mesh::TileId;
use trimtess::model::{PartId, shapes};
use trimtess::prepare::{PrepareOptions, Prepared, Tile, prepare};

/// Views around each model.
const VIEWS: usize = 6;
/// How often a tile is made; the least time counts.
const TIMES: usize = 4;
/// Tessellants of a cell beyond which its polygon takes longer.
const CROWD: f64 = 32.0;
const TERMS: usize = 4;

/// A tile in a view.
struct Sample {
    /// 1, cells, tessellants, tessellants beyond the crowd.
    terms: [f64; TERMS],
    /// Nanoseconds.
    cost: f64,
    weight: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut files = Vec::new();
    for name in std::env::args().skip(1) {
        let model = match name.strip_prefix("builtin:") {
            Some(shape) => shapes::by_name(shape).ok_or_else(|| format!("no {name}"))?,
            None => read_file(name.as_ref(), &StepOptions::default())?,
        };
        let prepared = prepare(model, &PrepareOptions::DEFAULT)?;
        let short = name.rsplit('/').next().unwrap_or(&name).to_owned();
        files.push((short, samples(&prepared)));
    }
    let all: Vec<&Sample> = files.iter().flat_map(|(_, samples)| samples).collect();
    if all.len() < TERMS {
        return Err("usage: tile_costs FILE...: STEP files, or builtin:NAME".into());
    }
    let fit = fit(&all);
    println!(
        "{} tiles: ns for a tile {:.0}, a cell {:.0}, a tessellant {:.0}, one in a crowd {:.0} more",
        all.len(),
        fit[0],
        fit[1],
        fit[2],
        fit[3]
    );
    println!(
        "                           file  samples   ms | correlation of costs with the fit, weights | of their logarithms"
    );
    for (name, samples) in &files {
        tell(name, samples, &fit);
    }
    Ok(())
}

fn samples(prepared: &Prepared) -> Vec<Sample> {
    let Some(bounds) = prepared.bounds else { return Vec::new() };
    let picture = Picture { size: (1920, 1080), deviation_px: 0.5, size_px: None, angle: FRAC_PI_6 };
    let mut scratch = Scratch::default();
    let mut samples = Vec::new();
    for view in CameraPath::Orbit.views(bounds, VIEWS, &picture) {
        let plan = plan_for_view(prepared, &view);
        let mut costs = vec![f64::INFINITY; prepared.tiles().count()];
        for _ in 0..TIMES {
            for ((part, tile, _), cost) in prepared.tiles().zip(&mut costs) {
                let begun = Instant::now();
                let made = tessellate_tile(prepared, &plan, part, tile, &mut scratch);
                *cost = cost.min(1e9 * begun.elapsed().as_secs_f64());
                drop(std::hint::black_box(made));
            }
        }
        let sample = |((part, tile, row), cost): ((PartId, TileId, &Tile), f64)| Sample {
            terms: terms(&plan, part, tile, row),
            cost,
            weight: row.weight,
        };
        samples.extend(prepared.tiles().zip(costs).map(sample));
    }
    samples
}

fn terms(plan: &Plan, part: PartId, tile: TileId, row: &Tile) -> [f64; TERMS] {
    let plan = &plan.parts[part.index()];
    let (nu, nv) = plan.tiles[tile.0 as usize].cells();
    let cells = f64::from(nu) * f64::from(nv);
    let along = |edge: u32, from: u32, to: u32| {
        let breaks = &plan.edges[edge as usize].breaks;
        breaks[from as usize].abs_diff(breaks[to as usize])
    };
    let tessellants: u32 = row.loops.iter().flatten().map(|u| along(u.edge, u.from, u.to)).sum();
    let tessellants = f64::from(tessellants);
    [1.0, cells, tessellants, (tessellants - CROWD * cells).max(0.0)]
}

fn predicted(terms: &[f64; TERMS], fit: &[f64; TERMS]) -> f64 {
    terms.iter().zip(fit).map(|(a, b)| a * b).sum()
}

/// Least squares of relative errors, where those of more than a few tenths (tiles off the usual path) count by their size and not by its
/// square: Huber's estimate, by reweighting.
fn fit(samples: &[&Sample]) -> [f64; TERMS] {
    const ROUNDS: usize = 30;
    const USUAL: f64 = 0.3;
    let mut fit = [0.0; TERMS];
    for round in 0..ROUNDS {
        let mut normal = Mat::<f64>::zeros(TERMS, TERMS);
        let mut right = Mat::<f64>::zeros(TERMS, 1);
        for sample in samples {
            let off = predicted(&sample.terms, &fit) - sample.cost;
            let off = (off / sample.cost.max(predicted(&sample.terms, &fit))).abs();
            let trust = if round == 0 || off <= USUAL { 1.0 } else { USUAL / off };
            let scale = trust / (sample.cost * sample.cost);
            for i in 0..TERMS {
                right[(i, 0)] += scale * sample.terms[i] * sample.cost;
                for j in 0..TERMS {
                    normal[(i, j)] += scale * sample.terms[i] * sample.terms[j];
                }
            }
        }
        let solution = normal.partial_piv_lu().solve(&right);
        fit = std::array::from_fn(|i| solution[(i, 0)]);
    }
    fit
}

fn tell(name: &str, samples: &[Sample], fit: &[f64; TERMS]) {
    let costs: Vec<f64> = samples.iter().map(|s| s.cost).collect();
    let fitted: Vec<f64> = samples.iter().map(|s| predicted(&s.terms, fit)).collect();
    let weights: Vec<f64> = samples.iter().map(|s| s.weight).collect();
    let logs = |of: &[f64]| of.iter().map(|x| x.max(1.0).ln()).collect::<Vec<f64>>();
    let whole = 1e-6 * costs.iter().sum::<f64>() / VIEWS as f64;
    println!(
        "{name:>31} {:8} {whole:7.2} | {:6.3} {:6.3} | {:6.3} {:6.3}",
        samples.len(),
        correlation(&costs, &fitted),
        correlation(&costs, &weights),
        correlation(&logs(&costs), &logs(&fitted)),
        correlation(&logs(&costs), &logs(&weights))
    );
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    let (middle_a, middle_b) = (mean(a), mean(b));
    let product =
        |x: &[f64], p: f64, y: &[f64], q: f64| -> f64 { x.iter().zip(y).map(|(x, y)| (x - p) * (y - q)).sum() };
    let spread = product(a, middle_a, a, middle_a) * product(b, middle_b, b, middle_b);
    // What does not vary goes with nothing.
    if spread.is_normal() { product(a, middle_a, b, middle_b) / spread.sqrt() } else { 0.0 }
}
