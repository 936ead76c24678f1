//! Nanoseconds per lattice point, by degree, weights and lines per patch.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::{DVec2, DVec3};
use std::hint::black_box;
use trimtess::frame::internals::evaluate::evaluate_points;
use trimtess::frame::internals::lattice::{EvaluateScratch, evaluate_lattice};
use trimtess::model::NurbsSurface;
use trimtess::prepare::internals::BezierPatches;

/// One wavy Bézier patch.
fn patch(degree_u: usize, degree_v: usize, rational: bool) -> BezierPatches {
    let grid = || (0..=degree_u).flat_map(|i| (0..=degree_v).map(move |j| (i as f64, j as f64)));
    let points = grid().map(|(x, y)| DVec3::new(x, y, (1.7 * x + 0.9 * y).sin())).collect();
    let weights = if rational { grid().map(|(x, y)| 1.0 + 0.4 * (2.1 * x - y).cos()).collect() } else { Vec::new() };
    BezierPatches::new(&NurbsSurface::bezier((degree_u, degree_v), points, weights))
}

fn lattice(c: &mut Criterion) {
    let mut group = c.benchmark_group("evaluate/lattice");
    for (degree_u, degree_v, rational) in [(1, 1, false), (2, 1, true), (3, 3, false), (3, 3, true), (5, 5, true)] {
        let patches = patch(degree_u, degree_v, rational);
        for n in [4, 16, 64] {
            let lines: Vec<f64> = (0..n).map(|i| i as f64 / (n - 1) as f64).collect();
            let mut scratch = EvaluateScratch::default();
            let (mut p, mut q) = (vec![DVec3::ZERO; n * n], vec![DVec3::ZERO; n * n]);
            let places: Vec<u32> = (0..(n * n) as u32).collect();
            group.throughput(Throughput::Elements((n * n) as u64));
            let kind = if rational { "rational" } else { "polynomial" };
            group.bench_function(BenchmarkId::new(format!("{kind} {degree_u}x{degree_v}"), n), |b| {
                b.iter(|| {
                    let (p, q) = (&mut p[..], &mut q[..]);
                    // Owns its slices, as the closure of tiles does.
                    let put = move |k: usize, position, normal| (p[k], q[k]) = (position, normal);
                    evaluate_lattice(&patches, &lines, black_box(&lines), &places, &mut scratch, put)
                });
            });
        }
    }
    group.finish();
}

fn points(c: &mut Criterion) {
    let patches = patch(3, 3, true);
    let at: Vec<_> = (0..256).map(|i| DVec2::new(f64::from(i) / 255.0, (f64::from(i) * 0.37).fract())).collect();
    let (mut p, mut q) = (vec![DVec3::ZERO; at.len()], vec![DVec3::ZERO; at.len()]);
    let mut group = c.benchmark_group("evaluate/points");
    group.throughput(Throughput::Elements(256));
    group.bench_function("rational 3x3", |b| {
        b.iter(|| {
            evaluate_points(&patches, black_box(&at), &mut |first, points| {
                (first..).zip(points.iter()).for_each(|(k, point)| (p[k], q[k]) = point);
            })
        });
    });
    group.finish();
}

criterion_group!(benches, lattice, points);
criterion_main!(benches);
