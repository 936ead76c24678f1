//! Cost of updating a tile incrementally, vs tessellating it without history: by the fraction of its boundary that
//! changes, and for a lattice by the fraction of its lines that come and go.
//!
//! * `plane/*`: the plane of the brake assembly with the most tessellants; some of its edges gain a quarter more
//!   tessellants and lose them again;
//! * `plane, few/*`: the same for a plane with at most 96 tessellants;
//! * `edges/*`: the tile of the trimmed teapot with the most tessellants, its lattice unchanged;
//! * `lines/*`: that tile; a fraction of its strips, from one side on, is split and merged again.
//!
//! Each measurement goes there and back. `made` tessellates without history, which costs the same whatever changes.
#![allow(missing_docs, reason = "criterion's macro makes a public function")]

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::f64::consts::FRAC_PI_6;
use std::hint::black_box;
use std::sync::Arc;
use trimtess::frame::internals::{EdgePolyline, TileCache, TileLattice, UpdateScratch, tessellate_tile, update_tile};
use trimtess::frame::{Plan, Reuse, plan_for_view};
use trimtess::model::{PartId, SurfaceKind, TileId};
use trimtess::prepare::internals::Tile;
use trimtess::prepare::{PrepareOptions, Prepared, prepare};
use trimtess::view::{CameraPath, Picture};

const PICTURE: Picture = Picture { size: (1920, 1080), deviation_px: 0.5, size_px: None, angle: FRAC_PI_6 };
/// Percentage that changes.
const SHARES: [usize; 8] = [0, 5, 10, 20, 40, 60, 80, 100];
const NO_SAMPLES: Reuse = Reuse { samples: false, ..Reuse::ALL };
const NO_TRACE: Reuse = Reuse { trace: false, ..Reuse::ALL };
const NO_TRIANGLES: Reuse = Reuse { triangles: false, ..Reuse::ALL };
const WAYS: [(&str, Reuse); 4] =
    [("all", Reuse::ALL), ("no samples", NO_SAMPLES), ("no trace", NO_TRACE), ("no triangles", NO_TRIANGLES)];

/// A tile and a plan for it.
struct Case {
    prepared: Prepared,
    plan: Plan,
    part: PartId,
    tile: TileId,
}

impl Case {
    /// The tile of a model that maximises `best`, a measure of its tessellants.
    fn of(name: &str, best: impl Fn(usize, SurfaceKind) -> Option<usize>) -> Self {
        let prepared =
            prepare(trimtess_models::by_name(name).expect("a named shape"), &PrepareOptions::DEFAULT).expect("within");
        let view = CameraPath::Glu.views(prepared.bounds.expect("a placed model"), 2, &PICTURE)[0];
        let plan = plan_for_view(&prepared, &view);
        let rated = |(part, tile, row): (PartId, TileId, &Tile)| {
            let rows = &prepared.parts[part.index()];
            Some((best(tessellants(&plan, part, row), rows.faces[rows.face_of(row)].kind)?, part, tile))
        };
        let (_, part, tile) = prepared.tiles().filter_map(rated).max().expect("a tile");
        Self { prepared, plan, part, tile }
    }

    fn row(&self) -> &Tile {
        &self.prepared.parts[self.part.index()].tiles[self.tile.0 as usize]
    }

    /// The plan with about a quarter more tessellants on the first edges, up to a percentage of the tile's tessellants.
    /// Also returns the percentage reached.
    fn finer_edges(&self, percent: usize) -> (Plan, usize) {
        let mut plan = self.plan.clone();
        let all = tessellants(&plan, self.part, self.row());
        let mut changed = 0;
        for u in self.row().loops.iter().flatten() {
            let line = &mut plan.parts[self.part.index()].edges[u.edge.index()];
            let count = line.breaks[u.from as usize].abs_diff(line.breaks[u.to as usize]) as usize;
            if count < 2 || 100 * (changed + count / 2) > percent * all {
                continue;
            }
            *line = Arc::new(spread(line));
            changed += count;
        }
        (plan, 100 * changed / all)
    }

    /// The plan with a percentage of the lattice's strips, the first ones, cut in two.
    fn finer_lines(&self, percent: usize) -> Plan {
        let mut plan = self.plan.clone();
        let lattice = &mut plan.parts[self.part.index()].tiles[self.tile.0 as usize];
        let cut = |lines: &[f64]| {
            let strips = lines.len() - 1;
            let halves = lines.windows(2).take(strips * percent / 100).map(|w| 0.5 * (w[0] + w[1]));
            let mut lines: Vec<f64> = lines.iter().copied().chain(halves).collect();
            lines.sort_by(f64::total_cmp);
            lines
        };
        *lattice = Arc::new(TileLattice { us: cut(&lattice.us).into(), ..TileLattice::clone(lattice) });
        plan
    }

    fn made(&self, plan: &Plan, scratch: &mut UpdateScratch) -> usize {
        let outcome = tessellate_tile(&self.prepared, plan, self.part, self.tile, scratch.tile());
        let triangles = outcome.mesh.triangles.len();
        scratch.reuse(black_box(outcome.mesh));
        triangles
    }

    fn patched(&self, plan: &Plan, patch: Reuse, memory: &mut TileCache, scratch: &mut UpdateScratch) -> usize {
        let outcome = update_tile((&self.prepared, plan), (self.part, self.tile), patch, memory, scratch);
        let triangles = outcome.mesh.triangles.len();
        scratch.reuse(black_box(outcome.mesh));
        triangles
    }

    fn sweep(&self, c: &mut Criterion, name: &str, plan: impl Fn(usize) -> (Plan, usize)) {
        let mut group = c.benchmark_group(name);
        group.sample_size(20);
        group.warm_up_time(std::time::Duration::from_millis(300));
        group.measurement_time(std::time::Duration::from_secs(1));
        let mut last = None;
        for percent in SHARES {
            let (other, share) = plan(percent);
            if last.replace(share) == Some(share) {
                continue;
            }
            let plans = [&self.plan, &other];
            let mut scratch = UpdateScratch::default();
            group.bench_function(BenchmarkId::new("made", share), |b| {
                b.iter(|| plans.map(|plan| self.made(plan, &mut scratch)));
            });
            for (way, patch) in WAYS {
                let mut memory = TileCache::default();
                group.bench_function(BenchmarkId::new(way, share), |b| {
                    b.iter(|| plans.map(|plan| self.patched(plan, patch, &mut memory, &mut scratch)));
                });
            }
        }
        group.finish();
    }
}

/// Number of tessellants of a tile.
fn tessellants(plan: &Plan, part: PartId, tile: &Tile) -> usize {
    let edges = &plan.parts[part.index()].edges;
    let count = |breaks: &[u32], from: u32, to: u32| breaks[from as usize].abs_diff(breaks[to as usize]) as usize;
    tile.loops.iter().flatten().map(|u| count(&edges[u.edge.index()].breaks, u.from, u.to)).sum()
}

/// About a quarter more tessellants between any two breaks, evenly spaced.
fn spread(line: &EdgePolyline) -> EdgePolyline {
    let mut out = EdgePolyline { ts: std::iter::once(line.ts[0]).collect(), breaks: std::iter::once(0).collect() };
    for ends in line.breaks.windows(2) {
        let (a, b) = (line.ts[ends[0] as usize], line.ts[ends[1] as usize]);
        let count = (ends[1] - ends[0]) * 5 / 4 + 1;
        out.ts.extend((1..count).map(|k| a + (b - a) * f64::from(k) / f64::from(count)));
        out.ts.push(b);
        out.breaks.push(out.ts.len() as u32 - 1);
    }
    out
}

fn planes(c: &mut Criterion) {
    let plane = |kind| matches!(kind, SurfaceKind::Plane);
    let large = Case::of("brake-assembly", |count, kind| plane(kind).then_some(count));
    large.sweep(c, "plane", |percent| large.finer_edges(percent));
    let small = Case::of("brake-assembly", |count, kind| (plane(kind) && count <= 96).then_some(count));
    small.sweep(c, "plane, few", |percent| small.finer_edges(percent));
}

fn lattices(c: &mut Criterion) {
    let case = Case::of("trimmed-teapot", |count, _| Some(count));
    case.sweep(c, "edges", |percent| case.finer_edges(percent));
    case.sweep(c, "lines", |percent| (case.finer_lines(percent), percent));
}

criterion_group!(benches, planes, lattices);
criterion_main!(benches);
