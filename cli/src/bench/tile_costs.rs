//! Times of tiles on this machine -> the cost model of `Tile::weight` in `prepare`, by robust least squares (Huber).
//!
//! Each tile is made alone on one thread, for six views around each model at half a pixel of 1920 × 1080. Its cost is
//! the minimum of [`costs::tiles`]. The fit gives nanoseconds per tile, cell and boundary tessellant that minimize the
//! relative error over all tiles. For each file it prints the correlation of measured costs with the fit and with the
//! weights from `prepare`, which knows no view.

use super::costs;
use crate::input::{self, Input};
use crate::limits::unprepared;
use crate::{Common, Done, Failure};
use glam::{DMat3, DVec3};
use std::f64::consts::FRAC_PI_6;
use std::path::Path;
use trimtess::frame::internals::Scratch;
use trimtess::frame::{Plan, plan_for_view};
use trimtess::model::{PartId, TileId};
use trimtess::prepare::internals::Tile;
use trimtess::prepare::{Prepared, prepare};
use trimtess::view::{CameraPath, Picture};

/// Views around each model.
const VIEWS: usize = 6;
const TERMS: usize = 3;

/// A tile in a view.
struct Sample {
    /// 1, cells, tessellants.
    terms: [f64; TERMS],
    /// Nanoseconds.
    cost: f64,
    weight: f64,
}

/// Fit a cost model of tiles to times on this machine, and compare it with the weights from `prepare`.
#[derive(clap::Args)]
pub(super) struct TileCostsArgs {
    /// STEP files, or builtin:NAME.
    #[arg(value_name = "FILES", value_parser = input::parser(), required = true)]
    files: Vec<Input>,
}

impl TileCostsArgs {
    pub(super) fn inputs(&self) -> Vec<&Path> {
        self.files.iter().filter_map(Input::path).collect()
    }
}

pub(super) fn run(args: &TileCostsArgs, common: &Common) -> Result<Done, Failure> {
    let mut files = Vec::new();
    for input in &args.files {
        let model = input.read(&common.limits.step())?;
        let prepared = prepare(model, &common.prepare()).map_err(unprepared)?;
        files.push((input.name(), samples(&prepared)));
    }
    let all: Vec<&Sample> = files.iter().flat_map(|(_, samples)| samples).collect();
    if all.len() < TERMS {
        return Err(Failure::Cannot(format!("{} samples are too few to fit {TERMS} coefficients", all.len())));
    }
    let fit = fit(&all);
    if !fit.iter().all(|term| term.is_finite()) {
        return Err(Failure::cannot(
            "these tiles are too alike to tell apart what a tile, a cell and a tessellant cost",
        ));
    }
    let [tile, cell, tessellant] = fit;
    crate::tell(&format!(
        "{} tiles: ns per tile {tile:.0}, cell {cell:.0}, tessellant {tessellant:.0}\n\
         \x20                          file  samples   ms | correlation of costs with fit, weights | of logarithms\n",
        all.len(),
    ))?;
    files.iter().try_for_each(|(name, samples)| crate::tell(&row(name, samples, &fit)))?;
    Ok(Done::Clean)
}

fn samples(prepared: &Prepared) -> Vec<Sample> {
    let Some(bounds) = prepared.bounds else { return Vec::new() };
    let picture = Picture { size: (1920, 1080), deviation_px: 0.5, size_px: None, angle: FRAC_PI_6 };
    let mut scratch = Scratch::default();
    let mut samples = Vec::new();
    let all: Vec<(PartId, TileId)> = prepared.tiles().map(|(part, tile, _)| (part, tile)).collect();
    for view in CameraPath::Orbit.views(bounds, VIEWS, &picture) {
        let plan = plan_for_view(prepared, &view);
        let costs = costs::tiles(prepared, &plan, &all, &mut scratch);
        let sample = |((part, tile, row), ms): ((PartId, TileId, &Tile), f64)| Sample {
            terms: terms(&plan, part, tile, row),
            cost: 1e6 * ms,
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
    let tessellants: u32 = row.loops.iter().flatten().map(|u| along(u.edge.0, u.from, u.to)).sum();
    [1.0, cells, f64::from(tessellants)]
}

fn predicted(terms: &[f64; TERMS], fit: &[f64; TERMS]) -> f64 {
    terms.iter().zip(fit).map(|(a, b)| a * b).sum()
}

/// Fits relative errors by iteratively reweighted least squares with Huber's weights: errors above `USUAL` (tiles off
/// the usual path) count linearly, not squared.
fn fit(samples: &[&Sample]) -> [f64; TERMS] {
    const ROUNDS: usize = 30;
    const USUAL: f64 = 0.3;
    let mut fit = [0.0; TERMS];
    for round in 0..ROUNDS {
        let (mut normal, mut right) = (DMat3::ZERO, DVec3::ZERO);
        for sample in samples {
            let off = predicted(&sample.terms, &fit) - sample.cost;
            let off = (off / sample.cost.max(predicted(&sample.terms, &fit))).abs();
            let trust = if round == 0 || off <= USUAL { 1.0 } else { USUAL / off };
            let scale = trust / (sample.cost * sample.cost);
            let terms = DVec3::from_array(sample.terms);
            right += scale * sample.cost * terms;
            normal += DMat3::from_cols_array_2d(&sample.terms.map(|term| (scale * term * terms).to_array()));
        }
        fit = (normal.inverse() * right).to_array();
    }
    fit
}

/// One line of correlations for a file.
fn row(name: &str, samples: &[Sample], fit: &[f64; TERMS]) -> String {
    let costs: Vec<f64> = samples.iter().map(|s| s.cost).collect();
    let fitted: Vec<f64> = samples.iter().map(|s| predicted(&s.terms, fit)).collect();
    let weights: Vec<f64> = samples.iter().map(|s| s.weight).collect();
    let logs = |of: &[f64]| of.iter().map(|x| x.max(1.0).ln()).collect::<Vec<f64>>();
    let whole = 1e-6 * costs.iter().sum::<f64>() / VIEWS as f64;
    format!(
        "{name:>31} {:8} {whole:7.2} | {:6.3} {:6.3} | {:6.3} {:6.3}\n",
        samples.len(),
        correlation(&costs, &fitted),
        correlation(&costs, &weights),
        correlation(&logs(&costs), &logs(&fitted)),
        correlation(&logs(&costs), &logs(&weights))
    )
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    let (middle_a, middle_b) = (mean(a), mean(b));
    let product =
        |x: &[f64], p: f64, y: &[f64], q: f64| -> f64 { x.iter().zip(y).map(|(x, y)| (x - p) * (y - q)).sum() };
    let spread = product(a, middle_a, a, middle_a) * product(b, middle_b, b, middle_b);
    // Constants correlate with nothing.
    if spread.is_normal() { product(a, middle_a, b, middle_b) / spread.sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_costs_are_fitted_exactly() {
        let truth = [300.0, 55.0, 150.0];
        let sample = |k: u32| {
            let terms = [1.0, f64::from(1 + k % 7), f64::from(4 + k * k % 400)];
            Sample { terms, cost: predicted(&terms, &truth), weight: 0.0 }
        };
        let samples: Vec<Sample> = (0..200).map(sample).collect();
        let fit = fit(&samples.iter().collect::<Vec<_>>());
        assert!(fit.iter().zip(truth).all(|(a, b)| (a / b - 1.0).abs() < 1e-9), "{fit:?}");
    }
}
