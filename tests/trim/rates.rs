//! Prepared models under plans with arbitrary rates: nothing cracks, whatever lattices and edges a tile's neighbours
//! have.

use std::ops::RangeInclusive;
use std::sync::{Arc, OnceLock};

use arbitrary::{Result, Unstructured};
use glam::DVec2;
use trimtess::frame::internals::trim::{TrimOutput, TrimScratch, trim_tile};
use trimtess::frame::internals::{PartPlan, TileLattice, cell_coordinate};
use trimtess::frame::{self, Plan, Tolerance};
use trimtess::mesh::{MemorySink, check_scene};
use trimtess::model::SurfaceKind;
use trimtess::parallel::serial;
use trimtess::prepare::Prepared;
use trimtess::prepare::internals::{EdgeShape, PreparedPart, TileUse, UvCurve};

use crate::checker::{Tile, check};
use crate::common;
use crate::sequence::judge;

/// A plan that no tolerance produces. Tiles and edges take these numbers in turn, but never less than in the coarsest
/// plan, and no segment of an edge spans more than one cell in either direction.
#[derive(Clone, PartialEq, Debug)]
struct Rates {
    /// Index into [`trimtess_models::names`].
    shape: usize,
    /// Cells between two creases in u and in v.
    cells: Vec<[u8; 2]>,
    /// Segments between two breaks.
    segments: Vec<u8>,
    /// Ratio of the last gap to the first.
    growth: f64,
}

fn prepared(shape: usize) -> Arc<Prepared> {
    static ALL: OnceLock<Vec<Arc<Prepared>>> = OnceLock::new();
    let all = ALL.get_or_init(|| {
        let models = trimtess_models::names().filter_map(trimtess_models::by_name);
        models.map(common::prepared).collect()
    });
    Arc::clone(&all[shape % all.len()])
}

impl Rates {
    fn draw(u: &mut Unstructured<'_>) -> Result<Self> {
        let shape = u.int_in_range(0..=trimtess_models::names().count() - 1)?;
        let most = *u.choose(&[4, 1, 12, 40])?;
        let number = |u: &mut Unstructured<'_>| u.int_in_range(1..=most);
        let cells = (0..u.int_in_range(1..=7)?).map(|_| Ok([number(u)?, number(u)?])).collect::<Result<_>>()?;
        let segments = (0..u.int_in_range(1..=11)?).map(|_| number(u)).collect::<Result<_>>()?;
        Ok(Self { shape, cells, segments, growth: *u.choose(&[1.0, 5.0, 0.01])? })
    }

    /// Lines from `low` to `high` through `stops`, with `count` gaps between two stops but no fewer than in `least`.
    fn spread(&self, low: f64, high: f64, stops: &[f64], count: u8, least: &[f64]) -> Vec<f64> {
        let mut lines = vec![low];
        let inner = stops.iter().copied().filter(|&stop| stop > low && stop < high);
        for to in inner.chain([high]) {
            let from = lines[lines.len() - 1];
            let count = least.iter().filter(|&&t| t > from && t <= to).count().max(usize::from(count));
            let count = u32::try_from(count).unwrap_or(u32::MAX);
            lines.extend((1..count).map(|k| from + (to - from) * self.share(f64::from(k) / f64::from(count))));
            lines.push(to);
        }
        // Adjacent floating-point numbers have none between them.
        lines.dedup();
        lines
    }

    /// A monotone map of 0..1 onto itself whose slope grows by the ratio.
    fn share(&self, x: f64) -> f64 {
        x * (2.0 + (self.growth - 1.0) * x) / (1.0 + self.growth)
    }

    fn plan(&self, prepared: &Prepared) -> Plan {
        let coarsest = Tolerance { chord: f64::INFINITY, angle: f64::INFINITY, max_edge: None };
        let mut plan = frame::plan(prepared, &coarsest);
        for (part, plan) in prepared.parts.iter().zip(&mut plan.parts) {
            self.replan(part, plan);
        }
        plan
    }

    fn replan(&self, part: &PreparedPart, plan: &mut PartPlan) {
        for (k, (tile, lattice)) in part.tiles.iter().zip(&mut plan.tiles).enumerate() {
            let [nu, nv] = self.cells[k % self.cells.len()];
            let face = part.face_of(tile);
            let creases = &face.creases;
            // A plane does not bend, so its lines are even.
            let lines =
                Rates { growth: if face.kind == SurfaceKind::Plane { 1.0 } else { self.growth }, ..self.clone() };
            *lattice = Arc::new(TileLattice {
                us: lines.spread(tile.min.x, tile.max.x, &creases[0], nu, &lattice.us).into(),
                vs: lines.spread(tile.min.y, tile.max.y, &creases[1], nv, &lattice.vs).into(),
                chord: lattice.chord,
                loosest: lattice.loosest,
            });
        }
        for (k, (edge, line)) in part.edges.iter().zip(&mut plan.edges).enumerate() {
            if edge.uses.is_empty() {
                continue;
            }
            let count = self.segments[k % self.segments.len()];
            let stops: Vec<f64> = edge.breaks.iter().map(|b| b.t).collect();
            let mut ts = self.spread(stops[0], stops[stops.len() - 1], &stops, count, &line.ts);
            for &TileUse { tile, of_loop: l, index: used } in &edge.uses {
                let lattice = &plan.tiles[tile.0 as usize];
                let used = &part.tiles[tile.0 as usize].loops[l as usize][used as usize];
                let ends = [used.from, used.to].map(|k| stops[k as usize]);
                ts = within_cells(&ts, ends[0].min(ends[1])..=ends[0].max(ends[1]), &used.uv, lattice);
            }
            let line = Arc::make_mut(line);
            line.ts = ts.into();
            line.breaks = stops.iter().map(|stop| line.ts.partition_point(|t| t < stop) as u32).collect();
        }
    }

    /// Checks each tile by itself, and the mesh of all tiles.
    fn judge(&self) -> std::result::Result<(), String> {
        let prepared = prepared(self.shape);
        let plan = Arc::new(self.plan(&prepared));
        let (mut scratch, mut out) = (TrimScratch::default(), TrimOutput::default());
        for (part, plan) in prepared.parts.iter().zip(&plan.parts) {
            for number in 0..part.tiles.len() {
                let tile = trace(part, plan, number);
                let outcome = trim_tile(&tile.input(), &mut scratch, &mut out).map_err(|error| error.to_string())?;
                check(&tile.input(), &out, true).map_err(|fault| format!("tile {number}, {outcome:?}: {fault}"))?;
            }
        }
        let mut mesh = MemorySink::default();
        let report = serial(&prepared, &plan, false, &mut mesh).map_err(|error| error.to_string())?;
        if let Some(tile) = report.degraded.first() {
            return Err(format!("tile {}: {}", tile.tile.0, tile.degradation));
        }
        let facts = check_scene(&mesh).total;
        if !facts.is_well_formed() {
            return Err(format!("malformed: {facts}"));
        }
        let edges = prepared.parts.iter().zip(&plan.parts).flat_map(|(part, plan)| part.edges.iter().zip(&plan.edges));
        let once = edges.filter(|(edge, _)| edge.uses.len() == 1 && matches!(edge.shape, EdgeShape::Curve(_)));
        let open: usize = once.map(|(_, line)| line.ts.len() - 1).sum();
        let cracked = facts.unbalanced_edges != open as u64;
        if cracked { Err(format!("{open} segments should be open: {facts}")) } else { Ok(()) }
    }
}

/// Halves the gaps of `ts` in a range until each spans at most one cell in either direction.
fn within_cells(ts: &[f64], range: RangeInclusive<f64>, uv: &UvCurve, lattice: &TileLattice) -> Vec<f64> {
    let mut hint = 0;
    let mut at = |t: f64| {
        let p = uv.point(t, &mut hint);
        DVec2::new(cell_coordinate(&lattice.us, p.x), cell_coordinate(&lattice.vs, p.y))
    };
    let mut out = vec![ts[0]];
    for w in ts.windows(2) {
        let inside = range.contains(&w[0]) && range.contains(&w[1]);
        let mut parts = 1_u32;
        let part = |k: u32, parts: u32| w[0] + (w[1] - w[0]) * (f64::from(k) / f64::from(parts));
        while inside && parts < 256 {
            let points: Vec<DVec2> = (0..=parts).map(|k| at(part(k, parts))).collect();
            if points.windows(2).all(|p| (p[1] - p[0]).abs().max_element() <= 1.0 + 1e-9) {
                break;
            }
            parts *= 2;
        }
        out.extend((1..parts).map(|k| part(k, parts)));
        out.push(w[1]);
    }
    out
}

/// A tile's loops in cell units, traced as the frame does.
fn trace(part: &PreparedPart, plan: &PartPlan, number: usize) -> Tile {
    /// Points this close to the border snap to it.
    const SNAP: f64 = 1e-9;
    let lattice = &plan.tiles[number];
    let (nu, nv) = lattice.cells();
    let snap = |x: f64, last: u32| {
        let last = f64::from(last);
        if x < SNAP {
            0.0
        } else if x > last - SNAP {
            last
        } else {
            x
        }
    };
    let mut loops = Vec::new();
    for uses in &part.tiles[number].loops {
        let mut points = Vec::new();
        for used in uses {
            let line = &plan.edges[used.edge.index()];
            let (from, to) = (line.breaks[used.from as usize], line.breaks[used.to as usize]);
            let mut hint = 0;
            for k in 0..from.abs_diff(to) {
                let t = line.ts[if from < to { from + k } else { from - k } as usize];
                let uv = used.uv.point(t, &mut hint);
                let (x, y) = (cell_coordinate(&lattice.us, uv.x), cell_coordinate(&lattice.vs, uv.y));
                points.push(DVec2::new(snap(x, nu), snap(y, nv)));
            }
        }
        loops.push(points);
    }
    Tile::new((nu, nv), &loops)
}

#[test]
fn fuzz_rates() {
    judge!(40, 64, |bytes: &[u8]| {
        let Ok(rates) = Rates::draw(&mut Unstructured::new(bytes)) else { return };
        if let Err(fault) = rates.judge() {
            let Rates { shape, cells, segments, growth } = &rates;
            let fields =
                format!("shape: {shape}, cells: vec!{cells:?}, segments: vec!{segments:?}, growth: {growth:?}");
            panic!("{fault}\n\n#[test]\nfn NAME() {{\n    assert_eq!(Rates {{ {fields} }}.judge(), Ok(()));\n}}\n");
        }
    });
}
