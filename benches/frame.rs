//! One thread tessellating all tiles of a sphere and of a torus, chord by chord.
#![allow(missing_docs, reason = "criterion's macro makes a public function")]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use trimtess::frame::internals::{Scratch, tessellate_tile};
use trimtess::frame::{Tolerance, plan};
use trimtess::mesh::MeshLists;
use trimtess::model::shapes;
use trimtess::prepare::{PrepareOptions, prepare};

fn tiles(c: &mut Criterion) {
    for name in ["sphere", "torus"] {
        let model = shapes::by_name(name).expect("a named shape");
        let prepared = prepare(model, &PrepareOptions::DEFAULT).expect("within the limits");
        let mut group = c.benchmark_group(format!("frame/{name}"));
        for chord in [1e-1, 1e-2, 1e-3, 1e-4] {
            let plan = plan(&prepared, &Tolerance { chord, angle: 1.5, max_edge: None });
            let mut scratch = Scratch::default();
            let mut all = || -> u64 {
                let mut tile = |(part, tile, _)| {
                    let lists = MeshLists::ALL;
                    let made = tessellate_tile(&prepared, black_box(&plan), (part, tile), lists, &mut scratch);
                    let triangles = made.mesh.triangles.len() as u64;
                    scratch.reuse(made.mesh);
                    triangles
                };
                prepared.tiles().map(&mut tile).sum()
            };
            group.throughput(Throughput::Elements(all()));
            group.bench_function(BenchmarkId::from_parameter(chord), |b| b.iter(&mut all));
        }
        group.finish();
    }
}

criterion_group!(benches, tiles);
criterion_main!(benches);
