//! Microseconds per sub-box of a bounds table, by degree and weights.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec3;
use std::hint::black_box;
use trimtess::math::bounds::patch_bounds;
use trimtess::model::NurbsSurface;
use trimtess::prepare::internals::{BezierPatches, SurfaceBounds};

fn tables(c: &mut Criterion) {
    let mut group = c.benchmark_group("bounds/surface");
    for (degree_u, degree_v, rational) in [(1, 1, false), (2, 1, true), (2, 2, true), (3, 3, false), (3, 3, true)] {
        let grid = || (0..=degree_u).flat_map(|i| (0..=degree_v).map(move |j| (i as f64, j as f64)));
        let points = grid().map(|(x, y)| DVec3::new(x, y, (1.7 * x + 0.9 * y).sin())).collect();
        let weights =
            if rational { grid().map(|(x, y)| 1.0 + 0.4 * (2.1 * x - y).cos()).collect() } else { Vec::new() };
        let patches = BezierPatches::new(&NurbsSurface::bezier((degree_u, degree_v), points, weights));
        let boxes = SurfaceBounds::new(&patches).cells.len();
        group.throughput(Throughput::Elements(boxes as u64));
        let kind = if rational { "rational" } else { "polynomial" };
        group.bench_function(BenchmarkId::new(kind, format!("{degree_u}x{degree_v}")), |b| {
            b.iter(|| SurfaceBounds::new(black_box(&patches)));
        });
        let net = patches.patch(0, 0);
        group.throughput(Throughput::Elements(1));
        group.bench_function(BenchmarkId::new(format!("one net, {kind}"), format!("{degree_u}x{degree_v}")), |b| {
            b.iter(|| patch_bounds(degree_u + 1, black_box(net), rational));
        });
    }
    group.finish();
}

criterion_group!(benches, tables);
criterion_main!(benches);
