//! Cost of free trims, from curves to edges and tiles, by the number of elements.
//!
//! * `holes/*`: round holes in one patch;
//! * `segments/*`: segments of one polyline, a flower;
//! * `crossings/*`: lines across each other, by the number of their intersections.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;
use std::hint::black_box;
use trimtess::model::{FreeTrims, Model, NurbsSurface, PartBuilder, ShellKind, Surface, TrimCurve, TrimRule};
use trimtess::prepare::{FreeRegion, PrepareOptions, UvDomain, prepare};

fn model(curves: Vec<TrimCurve>) -> Model {
    let points = vec![DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::new(1.0, 1.0, 0.0)];
    let sheet = NurbsSurface::bezier((1, 1), points, Vec::new());
    let mut part = PartBuilder::new("sheet");
    let shell = part.plain_shell(ShellKind::Open);
    part.trimmed_face(Surface::Nurbs(sheet), shell, FreeTrims { rule: TrimRule::Handedness, curves }, false);
    part.finish().expect("a sound part").into()
}

fn holes(count: usize) -> Vec<TrimCurve> {
    let side = (count as f64).sqrt().ceil() as usize;
    let hole = |k: usize| {
        let cell = DVec2::new((k % side) as f64 + 0.5, (k / side) as f64 + 0.5) / side as f64;
        TrimCurve::circle(cell, 0.3 / side as f64).reversed()
    };
    (0..count).map(hole).collect()
}

fn segments(count: usize) -> Vec<TrimCurve> {
    let corner = |k: usize| {
        let turn = TAU * k as f64 / count as f64;
        DVec2::splat(0.5) + DVec2::from_angle(-turn) * (0.3 + 0.1 * (9.0 * turn).sin())
    };
    vec![TrimCurve::polygon((0..count).map(corner).collect())]
}

/// The same number of lines in both directions.
fn grid(points: usize) -> Vec<TrimCurve> {
    let side = (points as f64).sqrt() as usize;
    let at = |k: usize| (k as f64 + 0.5) / side as f64;
    let across = |k: usize| TrimCurve::polyline(vec![DVec2::new(at(k), 0.0), DVec2::new(at(k) + 1e-4, 1.0)]);
    let along = |k: usize| TrimCurve::polyline(vec![DVec2::new(0.0, at(k)), DVec2::new(1.0, at(k) + 1e-4)]);
    (0..side).flat_map(|k| [across(k), along(k)]).collect()
}

fn crowds(c: &mut Criterion) {
    for (name, make, counts) in [
        ("holes", holes as fn(usize) -> Vec<TrimCurve>, [50, 500, 5_000]),
        ("segments", segments, [2_000, 20_000, 200_000]),
    ] {
        let mut group = c.benchmark_group(name);
        group.sample_size(10);
        for count in counts {
            let model = model(make(count));
            group.throughput(Throughput::Elements(count as u64));
            group.bench_with_input(BenchmarkId::from_parameter(count), &model, |b, model| {
                b.iter(|| prepare(black_box(model.clone()), &PrepareOptions::DEFAULT).expect("within the limits"));
            });
        }
    }
    let mut group = c.benchmark_group("crossings");
    group.sample_size(10);
    for points in [100, 1_000, 10_000] {
        let trims = FreeTrims { rule: TrimRule::EvenOdd, curves: grid(points) };
        let domain = UvDomain::new(DVec2::ZERO, DVec2::ONE);
        group.throughput(Throughput::Elements(points as u64));
        group.bench_with_input(BenchmarkId::from_parameter(points), &trims, |b, trims| {
            b.iter(|| FreeRegion::new(black_box(trims), &domain).expect("a region"));
        });
    }
}

criterion_group!(benches, crowds);
criterion_main!(benches);
