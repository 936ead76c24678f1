//! Cost per patch of preparing adjacent bicubic patches without topology on a square, with and without the search for
//! common borders. The difference is the cost of the search.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec3;
use std::hint::black_box;
use trimtess::control::{Alone, Control};
use trimtess::model::{Model, NurbsSurface, PartBuilder, ShellKind, Surface};
use trimtess::prepare::{PrepareOptions, prepare_on};

/// `n` x `n` patches over a wavy square.
fn grid(n: usize) -> Model {
    let point = |i: usize, j: usize| {
        let (x, y) = (i as f64, j as f64);
        DVec3::new(x, y, 2.0 * (0.31 * x).sin() * (0.17 * y).cos())
    };
    let mut part = PartBuilder::new("grid");
    let shell = part.plain_shell(ShellKind::Open);
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (3 * i, 3 * j))) {
        let points = (0..4).flat_map(|a| (0..4).map(move |b| point(i + a, j + b))).collect();
        let surface = Surface::Nurbs(NurbsSurface::bezier((3, 3), points, Vec::new()));
        part.plain_face(surface, shell, Vec::new(), false);
    }
    part.finish().expect("a sound part").into()
}

fn bench(c: &mut Criterion) {
    let mut group = c.benchmark_group("borders");
    group.sample_size(10);
    for n in [10, 20, 40, 55, 80] {
        let model = grid(n);
        group.throughput(Throughput::Elements((n * n) as u64));
        for (name, border_tolerance) in [("shared", PrepareOptions::DEFAULT.border_tolerance), ("apart", 0.0)] {
            let options = PrepareOptions::DEFAULT.with_border_tolerance(border_tolerance);
            group.bench_function(BenchmarkId::new(name, n * n), |b| {
                b.iter_with_large_drop(|| prepare_on(&Alone, black_box(&model), &options, &Control::default()));
            });
        }
    }
}

criterion_group!(benches, bench);
criterion_main!(benches);
