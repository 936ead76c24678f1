//! Cost of a moving camera: plans without history, plans that follow the view, and whole frames of a session. By how
//! far the camera turns per frame (views per full turn, or at rest), and by how much there is out of sight.
#![allow(missing_docs, reason = "criterion's macro makes a public function")]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::{DAffine3, DVec3};
use std::f64::consts::FRAC_PI_6;
use std::hint::black_box;
use std::sync::Arc;
use trimtess::control::{Alone, Control};
use trimtess::frame::internals::{PlacedInstances, Planner};
use trimtess::frame::{PlanLimits, PlannerOptions, plan_for_view_on};
use trimtess::model::PartId;
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::{PrepareOptions, Prepared, prepare};
use trimtess::view::{Camera, CameraPath, Picture, Projection, View};

#[path = "common/nowhere.rs"]
mod nowhere;
use nowhere::Nowhere;

const PICTURE: Picture = Picture { size: (1920, 1080), deviation_px: 0.5, size_px: None, angle: FRAC_PI_6 };
/// Views per full turn; `None` is a camera at rest.
const STEPS: [Option<usize>; 4] = [None, Some(3600), Some(360), Some(36)];

fn models() -> impl Iterator<Item = (&'static str, Arc<Prepared>)> {
    ["trimmed-teapot", "brake-assembly"].into_iter().map(|name| {
        let model = trimtess_models::by_name(name).expect("a named shape");
        (name, Arc::new(prepare(model, &PrepareOptions::DEFAULT).expect("within the limits")))
    })
}

/// Views around a model, endlessly.
struct Turn {
    views: Vec<View>,
    next: usize,
}

impl Turn {
    fn of(prepared: &Prepared, steps: Option<usize>) -> Self {
        let bounds = prepared.bounds.expect("a placed model");
        Self { views: CameraPath::Orbit.views(bounds, steps.unwrap_or(1), &PICTURE), next: 0 }
    }

    fn view(&mut self) -> View {
        self.next = (self.next + 1) % self.views.len();
        self.views[self.next]
    }
}

fn pace(steps: Option<usize>) -> String {
    steps.map_or_else(|| "at rest".to_owned(), |steps| format!("{steps} a turn"))
}

fn plans(c: &mut Criterion) {
    for (name, prepared) in models() {
        let mut group = c.benchmark_group(format!("plan/{name}"));
        group.throughput(Throughput::Elements(prepared.tiles().count() as u64));
        let mut turn = Turn::of(&prepared, Some(36));
        let limits = PlanLimits::DEFAULT;
        group.bench_function("from nothing", |b| {
            b.iter(|| plan_for_view_on(&Alone, &prepared, black_box(&turn.view()), &limits, &Control::default()));
        });
        for steps in STEPS {
            let mut turn = Turn::of(&prepared, steps);
            let mut planner = Planner::new(Arc::clone(&prepared), &PlannerOptions::DEFAULT);
            let mut placed = PlacedInstances::of(&prepared);
            group.bench_function(BenchmarkId::from_parameter(pace(steps)), |b| {
                b.iter(|| {
                    planner.plan(&mut placed, &[turn.view()]);
                    planner.changes().tiles.len()
                });
            });
        }
        group.finish();
    }
}

fn frames(c: &mut Criterion) {
    for (name, prepared) in models() {
        let mut group = c.benchmark_group(format!("session/{name}"));
        group.sample_size(20);
        for threads in [1, 2] {
            let options = SessionOptions::DEFAULT.with_threads(threads).with_edge_lines(false);
            for steps in STEPS {
                let mut turn = Turn::of(&prepared, steps);
                let mut session = Session::start(Arc::clone(&prepared), &options).expect("threads");
                let id = BenchmarkId::new(format!("{threads} threads"), pace(steps));
                group.bench_function(id, |b| {
                    b.iter(|| session.view(&[turn.view()], &mut Nowhere).expect("a frame").tiles)
                });
            }
        }
        group.finish();
    }
}

/// A row of parts, of which a camera at one end sees the first few. It turns so little that no tile changes. By the
/// number of tiles.
fn crowds(c: &mut Criterion) {
    let model = trimtess_models::by_name("flower-teapot").expect("a named shape");
    let one = prepare(model, &PrepareOptions::DEFAULT).expect("within the limits");
    let [low, high] = one.bounds.expect("a placed model");
    let step = 1.5 * (high.x - low.x);
    let mut group = c.benchmark_group("session/out of sight");
    for count in [10, 100, 1000] {
        let mut many = one.clone();
        for k in 1..count {
            Arc::make_mut(&mut many.parts).push(Arc::clone(&one.parts[0]));
            many.scene.parts.push(one.scene.parts[0].clone());
            let mut instance = one.scene.instances[0].clone();
            instance.part = PartId::new(k);
            instance.transform = DAffine3::from_translation(DVec3::X * (step * k as f64));
            many.scene.instances.push(instance);
        }
        let prepared = Arc::new(many);
        let projection = Projection::Orthographic { height: 10.0 * (high.z - low.z) };
        let eye = 0.5 * (low + high) - DVec3::Y * 1e4;
        let camera = Camera::looking_at(eye, eye + DVec3::Y, DVec3::Z, projection);
        let views = [0.0, 1e-6].map(|x| {
            let camera = Camera { eye: eye + DVec3::X * x, ..camera };
            View { camera, size: PICTURE.size, deviation_px: 0.5, size_px: None, angle: PICTURE.angle }
        });
        let options = SessionOptions::DEFAULT.with_edge_lines(false);
        let mut session = Session::start(Arc::clone(&prepared), &options).expect("threads");
        for k in 0..80 {
            session.view(&[views[k % 2]], &mut Nowhere).expect("a frame");
        }
        let drawn = session.plan().map_or(0, |plan| (0..count).map(|k| plan.drawn.tiles(0, k).count()).sum::<usize>());
        let tiles = prepared.tiles().count();
        let mut k = 0;
        group.bench_function(format!("{drawn} of {tiles} tiles"), |b| {
            b.iter(|| {
                k += 1;
                session.view(&[views[k % 2]], &mut Nowhere).expect("a frame").tiles
            });
        });
    }
    group.finish();
}

criterion_group!(benches, plans, frames, crowds);
criterion_main!(benches);
