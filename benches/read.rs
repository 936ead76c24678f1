//! Cost per byte of reading one STEP file, by its size: 1, 4, 16 and 64 copies of a solid.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use trimtess::control::{Alone, Control};
use trimtess::import::step::{StepOptions, read_on};

const SOLID: &str = include_str!("../tests/data/nist_ctc05.step");

/// A file with the entities of `SOLID` so many times, each time with numbers of their own.
fn copies(count: usize) -> String {
    let (header, rest) = SOLID.split_once("DATA;").expect("a data section");
    let (entities, end) = rest.rsplit_once("ENDSEC;").expect("its end");
    // No text of this file contains the sign.
    let mut pieces = entities.split('#');
    let before = pieces.next().unwrap_or_default();
    let pieces: Vec<(usize, &str)> = pieces
        .map(|piece| {
            let digits = piece.find(|c: char| !c.is_ascii_digit()).unwrap_or(piece.len());
            (piece[..digits].parse().expect("a number"), &piece[digits..])
        })
        .collect();
    let numbers = 1 + pieces.iter().map(|(number, _)| *number).max().unwrap_or(0);
    let mut text = format!("{header}DATA;{before}");
    for copy in 0..count {
        for (number, after) in &pieces {
            text.push_str(&format!("#{}{after}", number + copy * numbers));
        }
    }
    text + "ENDSEC;" + end
}

fn bench(c: &mut Criterion) {
    let mut group = c.benchmark_group("read");
    group.sample_size(10);
    for count in [1, 4, 16, 64] {
        let text = copies(count);
        let read = || read_on(&Alone, black_box(text.as_bytes()), &StepOptions::DEFAULT, &Control::default());
        assert_eq!(read().map(|model| model.parts.len()).ok(), Some(count), "copies");
        group.throughput(Throughput::Bytes(text.len() as u64));
        group.bench_function(BenchmarkId::new("copies", count), |b| b.iter_with_large_drop(read));
    }
}

criterion_group!(benches, bench);
criterion_main!(benches);
