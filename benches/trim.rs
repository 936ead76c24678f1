//! Cost of the trim triangulation per tessellant.
//!
//! * `lattice/*`: 32 x 32 cells, by the length of segments in cells;
//! * `one_cell/*`: planes (tiles of one cell): discs, stars and combs by the number of tessellants, plates by that of
//!   their holes, which are round, square or scattered;
//! * `cylinder/*`: tiles of one row;
//! * `reference/*`: the whole-tile reference on the first tile, for comparison.

use std::f64::consts::TAU;
use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec2;
use trimtess::frame::internals::trim::{TrimInput, TrimOutput, TrimScratch, reference, trim_tile};

struct Tile {
    cells: (u32, u32),
    points: Vec<DVec2>,
    loop_starts: Vec<u32>,
}

impl Tile {
    fn new(cells: (u32, u32)) -> Self {
        Self { cells, points: Vec::new(), loop_starts: vec![0] }
    }

    fn with(mut self, points: impl IntoIterator<Item = DVec2>) -> Self {
        self.points.extend(points);
        self.loop_starts.push(self.points.len() as u32);
        self
    }

    fn with_border(self, segment: f64) -> Self {
        let (w, h) = (f64::from(self.cells.0), f64::from(self.cells.1));
        let corners = [DVec2::ZERO, DVec2::new(w, 0.0), DVec2::new(w, h), DVec2::new(0.0, h)];
        let side = move |k: usize| {
            let (a, b) = (corners[k], corners[(k + 1) % 4]);
            let steps = (a.distance(b) / segment).ceil() as u32;
            (0..steps).map(move |s| a.lerp(b, f64::from(s) / f64::from(steps)))
        };
        self.with((0..4).flat_map(side))
    }

    fn input(&self) -> TrimInput<'_> {
        TrimInput { cells: self.cells, points: &self.points, loop_starts: &self.loop_starts, places: &[] }
    }
}

/// A wavy loop with segments of about the given length; clockwise if `turns` is -1.
fn wavy(centre: DVec2, radius: f64, segment: f64, turns: f64) -> impl Iterator<Item = DVec2> {
    let count = ((TAU * radius / segment).ceil() as u32).max(3);
    (0..count).map(move |k| {
        let angle = turns * TAU * f64::from(k) / f64::from(count);
        centre + DVec2::from_angle(angle) * radius * (1.0 + 0.15 * (3.0 * angle).sin())
    })
}

/// A border and three holes.
fn pierced(segment: f64) -> Tile {
    let mut tile = Tile::new((32, 32)).with_border(segment);
    for (x, y, radius) in [(9.3, 8.1, 5.0), (22.7, 12.4, 6.5), (14.2, 24.6, 4.5)] {
        tile = tile.with(wavy(DVec2::new(x, y), radius, segment, -1.0));
    }
    tile
}

/// A trim loop instead of the border, with a hole.
fn trimmed(segment: f64) -> Tile {
    let centre = DVec2::new(16.1, 15.7);
    Tile::new((32, 32)).with(wavy(centre, 13.0, segment, 1.0)).with(wavy(centre, 5.0, segment, -1.0))
}

/// One cell with a disc of `count` tessellants.
fn disc(count: u32) -> Tile {
    Tile::new((1, 1)).with(wavy(DVec2::splat(0.5), 0.4, TAU * 0.4 / f64::from(count), 1.0))
}

/// A plate with `holes` x `holes` round holes of 24 tessellants.
fn plate(cells: (u32, u32), holes: u32) -> Tile {
    let mut tile = Tile::new(cells).with_border(1.0);
    let size = DVec2::new(f64::from(cells.0), f64::from(cells.1));
    for i in 0..holes {
        for j in 0..holes {
            let centre = size * (DVec2::new(f64::from(i), f64::from(j)) + 0.5) / f64::from(holes);
            let radius = 0.3 * size.min_element() / f64::from(holes);
            tile = tile.with(wavy(centre, radius, TAU * radius / 24.0, -1.0));
        }
    }
    tile
}

/// One cell with `rows` x `rows` square holes, corner by corner in line.
fn squares(rows: u32) -> Tile {
    let corners = [[0.25, 0.25], [0.25, 0.75], [0.75, 0.75], [0.75, 0.25]].map(DVec2::from_array);
    let mut tile = Tile::new((1, 1)).with_border(1.0);
    for (i, j) in (0..rows).flat_map(|i| (0..rows).map(move |j| (i, j))) {
        let corner = DVec2::new(f64::from(i), f64::from(j));
        tile = tile.with(corners.map(|p| (corner + p) / f64::from(rows)));
    }
    tile
}

/// One cell with a disc of `count` tessellants along 13 deep waves.
fn star(count: u32) -> Tile {
    let corner = move |k: u32| {
        let angle = TAU * f64::from(k) / f64::from(count);
        DVec2::splat(0.5) + DVec2::from_angle(angle) * 0.35 * (1.0 + 0.2 * (13.0 * angle).sin())
    };
    Tile::new((1, 1)).with((0..count).map(corner))
}

/// Numbers from 0 to 1 that no processor foresees, the same in each run.
fn random() -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A plate with `holes` x `holes` holes of 12 to 36 tessellants, of any size and anywhere in their squares.
fn scattered(holes: u32) -> Tile {
    let mut random = random();
    let mut tile = Tile::new((1, 1)).with_border(1.0);
    for i in 0..holes {
        for j in 0..holes {
            let radius = 0.03 + 0.4 * random().powi(2);
            let room = 1.0 - 2.1 * radius;
            let within = DVec2::new(random(), random()) * room + 1.05 * radius;
            let centre = (DVec2::new(f64::from(i), f64::from(j)) + within) / f64::from(holes);
            let count = 12.0 + (25.0 * random()).floor();
            tile = tile.with(
                (0..count as u32)
                    .map(move |k| centre + DVec2::from_angle(-TAU * f64::from(k) / count) * radius / f64::from(holes)),
            );
        }
    }
    tile
}

/// One cell with a comb of `count` tessellants, whose teeth are of any depth. It is wider than tall: the sweep meets
/// the teeth in no order.
fn comb(count: u32) -> Tile {
    let mut random = random();
    let teeth = count / 2;
    let tooth = |k: u32| {
        let y = |part: f64| 0.8 - 0.6 * (f64::from(k) + part) / f64::from(teeth);
        [DVec2::new(0.1 + 0.6 * random(), y(0.0)), DVec2::new(0.8, y(0.5))]
    };
    let points: Vec<_> = (0..teeth).flat_map(tooth).chain([DVec2::new(0.9, 0.2), DVec2::new(0.9, 0.8)]).collect();
    Tile::new((1, 1)).with(points)
}

/// A comb whose teeth end in no order.
fn mirrored_comb(count: u32) -> Tile {
    let mut tile = comb(count);
    tile.points.reverse();
    tile.points.iter_mut().for_each(|p| p.x = 1.0 - p.x);
    tile
}

/// One cell with a comb as a hole: each tooth splits an interval of the sweep line.
fn comb_hole(count: u32) -> Tile {
    let mut points = comb(count).points;
    points.reverse();
    Tile::new((1, 1)).with_border(1.0).with(points)
}

/// One cell with a hole whose teeth lean, to both sides: half of them split an interval whichever way the sweep goes.
fn double_comb_hole(count: u32) -> Tile {
    let mut random = random();
    let teeth = count / 4;
    let lean = |x: f64, k: f64| DVec2::new(x, 0.35 + 0.3 * k / f64::from(teeth) + 0.4 * (x - 0.5));
    let mut side = |outer: f64, inner: f64| {
        let tooth =
            |k: u32| [lean(outer + (0.5 - outer) * 0.8 * random(), f64::from(k)), lean(inner, f64::from(k) + 0.5)];
        (0..teeth).flat_map(tooth).collect::<Vec<_>>()
    };
    let (left, right) = (side(0.1, 0.49), side(0.9, 0.51));
    Tile::new((1, 1)).with_border(1.0).with(left.into_iter().chain(right.into_iter().rev()))
}

fn bench(c: &mut Criterion) {
    let mut run = |group: &str, id: BenchmarkId, tile: &Tile| {
        let (mut scratch, mut out) = (TrimScratch::default(), TrimOutput::default());
        let mut group = c.benchmark_group(group);
        group.throughput(Throughput::Elements(tile.points.len() as u64));
        group.bench_function(id, |b| {
            b.iter(|| trim_tile(black_box(&tile.input()), &mut scratch, &mut out).expect("valid input"));
        });
    };
    for segment in [1.0, 0.5, 0.2, 0.1] {
        run("lattice", BenchmarkId::new("pierced", segment), &pierced(segment));
        run("lattice", BenchmarkId::new("trimmed", segment), &trimmed(segment));
    }
    for count in [4, 8, 12, 16, 24, 32, 40, 64, 256, 4_096, 100_000] {
        run("one_cell", BenchmarkId::new("disc", count), &disc(count));
    }
    for holes in [1, 4, 16, 64] {
        run("one_cell", BenchmarkId::new("plate", holes * holes), &plate((1, 1), holes));
    }
    for rows in [16, 64, 160, 640] {
        run("one_cell", BenchmarkId::new("squares", rows * rows), &squares(rows));
    }
    for holes in [4, 16, 64] {
        run("one_cell", BenchmarkId::new("scattered", holes * holes), &scattered(holes));
    }
    for count in [400, 2_000, 4_096, 100_000] {
        run("one_cell", BenchmarkId::new("star", count), &star(count));
    }
    for count in [1_000, 10_000, 100_000] {
        run("one_cell", BenchmarkId::new("comb", count), &comb(count));
        run("one_cell", BenchmarkId::new("mirrored_comb", count), &mirrored_comb(count));
        run("one_cell", BenchmarkId::new("comb_hole", count), &comb_hole(count));
        run("one_cell", BenchmarkId::new("double_comb_hole", count), &double_comb_hole(count));
    }
    run("cylinder", BenchmarkId::new("plate", 16), &plate((40, 1), 4));
    let tile = pierced(1.0);
    let mut out = TrimOutput::default();
    let mut group = c.benchmark_group("reference");
    group.throughput(Throughput::Elements(tile.points.len() as u64));
    group.bench_function("pierced/1", |b| {
        b.iter(|| reference::trim_tile_reference(black_box(&tile.input()), &mut out).expect("valid input"));
    });
}

criterion_group!(benches, bench);
criterion_main!(benches);
