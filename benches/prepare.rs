//! Cost per face of preparing one part, by its number of faces: washers in a square, each of two cylinders and two
//! planes.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec3;
use std::hint::black_box;
use trimtess::control::{Alone, Control};
use trimtess::model::{Frame3, Loop, Model, PartBuilder, ShellKind, Surface};
use trimtess::prepare::{PrepareOptions, prepare_on};

/// Adds a washer of radii 6 and 10 and height 3.
fn washer(part: &mut PartBuilder, at: DVec3) {
    let shell = part.plain_shell(ShellKind::Outer);
    let [low, high] = [at, at + 3.0 * DVec3::Z].map(|origin| Frame3 { origin, ..Frame3::WORLD });
    let [inner, outer] = [6.0, 10.0].map(|radius| [low, high].map(|frame| part.circle(&frame, radius)));
    for (radius, [below, above], reversed) in [(10.0, outer, false), (6.0, inner, true)] {
        let loops = vec![Loop::Edges(vec![below.along()]), Loop::Edges(vec![above.against()])];
        part.plain_face(Surface::Cylinder { frame: low, radius }, shell, loops, reversed);
    }
    for (k, frame, reversed) in [(0, low, true), (1, high, false)] {
        let loops = vec![Loop::Edges(vec![outer[k].along()]), Loop::Edges(vec![inner[k].against()])];
        part.plain_face(Surface::Plane { frame }, shell, loops, reversed);
    }
}

/// `n` x `n` washers.
fn washers(n: u32) -> Model {
    let mut part = PartBuilder::new("washers");
    for (x, y) in (0..n).flat_map(|x| (0..n).map(move |y| (x, y))) {
        washer(&mut part, 25.0 * DVec3::new(f64::from(x), f64::from(y), 0.0));
    }
    part.finish().expect("a sound part").into()
}

fn bench(c: &mut Criterion) {
    let mut group = c.benchmark_group("prepare");
    group.sample_size(10);
    for n in [5, 10, 20, 40, 80] {
        let model = washers(n);
        let faces = model.parts[0].faces.len();
        group.throughput(Throughput::Elements(faces as u64));
        group.bench_function(BenchmarkId::new("faces", faces), |b| {
            b.iter_with_large_drop(|| {
                prepare_on(&Alone, black_box(&model), &PrepareOptions::DEFAULT, &Control::default())
            });
        });
    }
}

criterion_group!(benches, bench);
criterion_main!(benches);
