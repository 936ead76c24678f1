//! A model, and numbers of threads -> how the time of each stage falls with them: reading, preparing, cold and coherent
//! frames, and larger models on more threads.

use super::flight::{Coherence, Flight, Order, Times, fly, ms};
use super::steps::{Replayed, replay};
use super::summary::Machine;
use super::{hash, plot};
use crate::input::Input;
use crate::limits::unprepared;
use crate::logging::Progress;
use crate::outputs::Outputs;
use crate::{Common, Done, Failure};
use plotters::prelude::*;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;
use trimtess::control::{Control, Rayon};
use trimtess::glam::{DAffine3, DVec3};
use trimtess::model::{Instance, Model, PartId};
use trimtess::prepare::{Prepared, prepare_on};
use trimtess::view::View;

/// What to measure.
pub(super) struct Plan<'a> {
    pub(super) input: &'a Input,
    /// Copies of the model's parts, side by side.
    pub(super) copies: u32,
    /// Times that each stage is measured; the minimum counts.
    pub(super) rounds: u32,
    /// Numbers of threads, ascending.
    pub(super) threads: Vec<usize>,
}

/// Times by the number of threads.
#[derive(Serialize)]
pub(super) struct Scaling {
    model: String,
    machine: Machine,
    faces: usize,
    threads: Vec<usize>,
    stages: Vec<Stage>,
    /// Cold and coherent frames on more threads than there may be.
    replayed: Vec<Replayed>,
    /// Hashes of the last frame, cold and coherent, by number of threads: all rows are equal.
    hashes: Vec<[String; 2]>,
    /// As many copies of the model as threads.
    weak: Vec<Weak>,
    #[serde(skip)]
    pub(super) done: Done,
}

/// A stage's times.
#[derive(Serialize)]
struct Stage {
    name: &'static str,
    ms: Vec<f64>,
    /// Time on one thread, divided by the time.
    speedup: Vec<f64>,
    /// The share of work that does not get faster, as Karp and Flatt (1990) derive it from the speedup; `null` for one
    /// thread.
    serial_fraction: Vec<Option<f64>>,
}

impl Stage {
    fn of(name: &'static str, threads: &[usize], ms: Vec<f64>) -> Self {
        let one = ms.first().copied().unwrap_or(0.0);
        let speedup: Vec<f64> = ms.iter().map(|&ms| if ms > 0.0 { one / ms } else { 1.0 }).collect();
        let serial = |(&p, &speedup): (&usize, &f64)| {
            let p = p as f64;
            (p > 1.0).then(|| (1.0 / speedup - 1.0 / p) / (1.0 - 1.0 / p))
        };
        let serial_fraction = threads.iter().zip(&speedup).map(serial).collect();
        Self { name, ms, speedup, serial_fraction }
    }
}

/// A model that grows with the number of threads.
#[derive(Serialize)]
struct Weak {
    threads: usize,
    faces: usize,
    prepare_ms: f64,
    frame_ms: f64,
    /// Time of one copy on one thread, divided by the time.
    prepare_efficiency: f64,
    frame_efficiency: f64,
}

/// 1, 2, 4 … and the number of cores.
pub(super) fn up_to(cores: usize) -> Vec<usize> {
    let mut threads: Vec<usize> = std::iter::successors(Some(1), |n| Some(2 * n)).take_while(|n| *n < cores).collect();
    threads.push(cores);
    threads
}

/// Measures. `views` makes the camera path of a model.
pub(super) fn measure(
    plan: &Plan<'_>,
    views: &dyn Fn(&Prepared) -> Result<Vec<View>, Failure>,
    common: &Common,
    progress: &Progress,
) -> Result<Scaling, Failure> {
    let mut columns: [Vec<f64>; 10] = Default::default();
    let one = ready(&plan.input.read(&common.limits.step())?, common)?;
    let step = 1.1 * one.diagonal;
    let (mut hashes, mut weak, mut faces, mut done) = (Vec::new(), Vec::<Weak>::new(), 0, Done::Clean);
    let mut last = None;
    for &threads in &plan.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(Failure::cannot)?;
        progress.stage(format!("{threads} threads: reading"));
        let (model, read) = least(plan.rounds, || pool.install(|| plan.input.read(&common.limits.step())))?;
        let all = side_by_side(&model, plan.copies, step);
        faces = all.parts.iter().map(|part| part.faces.len()).sum();
        progress.stage(format!("{threads} threads: preparing {faces} faces"));
        let made = || pool.install(|| ready(&all, common));
        let (prepared, prepared_in) = least(plan.rounds, made)?;
        let (prepared, path) = (Arc::new(prepared), views);
        let views = path(&prepared)?;
        done = Done::of(&prepared);
        progress.stage(format!("{threads} threads: flying"));
        let flown = |prepared: &Arc<Prepared>, views: &[View], coherence| {
            let (workers, rounds, written) = (0, plan.rounds as usize, true);
            fly(&Order { prepared, views, threads, workers, coherence, written, rounds }, common)
        };
        let cold = flown(&prepared, &views, Coherence::Off)?;
        let coherent = flown(&prepared, &views, Coherence::On)?;
        let mean = |flight: &Flight, of: fn(&Times) -> f64| {
            flight.times.iter().map(of).sum::<f64>() / flight.times.len().max(1) as f64
        };
        let parts: [fn(&Times) -> f64; 4] = [|t| t.plan, |t| t.make, |t| t.commit, |t| t.frame];
        let of_frames = [&cold, &coherent].into_iter().flat_map(|flight| parts.map(|of| mean(flight, of)));
        columns.iter_mut().zip([read, prepared_in].into_iter().chain(of_frames)).for_each(|(c, ms)| c.push(ms));
        let of_frames = hash::of_last(&prepared, &views, threads, &common.limits)?;
        hashes.push(of_frames.map(|hash| format!("{hash:016x}")));
        last = Some((prepared, views));

        progress.stage(format!("{threads} threads: {threads} copies"));
        let copies = side_by_side(&model, u32::try_from(threads).unwrap_or(u32::MAX), step);
        let made = || pool.install(|| ready(&copies, common));
        let (grown, prepare_ms) = least(plan.rounds, made)?;
        let grown = Arc::new(grown);
        let frame_ms = mean(&flown(&grown, &path(&grown)?, Coherence::Off)?, |t| t.frame);
        let faces = grown.parts.iter().map(|part| part.faces.len()).sum();
        let (first_prepare, first_frame) = weak.first().map_or((prepare_ms, frame_ms), |w| (w.prepare_ms, w.frame_ms));
        let (prepare_efficiency, frame_efficiency) = (first_prepare / prepare_ms, first_frame / frame_ms);
        weak.push(Weak { threads, faces, prepare_ms, frame_ms, prepare_efficiency, frame_efficiency });
    }
    let names = ["read", "prepare", "cold: plan", "cold: tiles", "cold: commit", "cold frame", "coherent: plan"];
    let names = names.into_iter().chain(["coherent: tiles", "coherent: commit", "coherent frame"]);
    let mut replayed = Vec::new();
    for (cold, frames) in [(true, &columns[5]), (false, &columns[9])] {
        progress.stage("computing frames on more threads");
        let measured: Vec<(usize, f64)> = plan.threads.iter().copied().zip(frames.iter().copied()).collect();
        if let Some((prepared, views)) = &last {
            replayed.push(replay((prepared, views, plan.rounds), cold, &measured, common)?);
        }
    }
    let stages = names.zip(columns).map(|(name, ms)| Stage::of(name, &plan.threads, ms)).collect();
    let (model, machine, threads) = (plan.input.name(), Machine::this(), plan.threads.clone());
    Ok(Scaling { model, machine, faces, threads, stages, replayed, hashes, weak, done })
}

/// Prepares a model without a copy of it, which would be timed, too.
fn ready(model: &Model, common: &Common) -> Result<Prepared, Failure> {
    prepare_on(&Rayon, model, &common.prepare(), &Control::default()).map_err(unprepared)
}

/// The result of `work`, and the least of its times, milliseconds.
fn least<T>(rounds: u32, work: impl Fn() -> Result<T, Failure>) -> Result<(T, f64), Failure> {
    let timed = || -> Result<(T, f64), Failure> {
        let start = Instant::now();
        let made = work()?;
        Ok((made, ms(start.elapsed())))
    };
    let mut best = timed()?;
    for _ in 1..rounds {
        let next = timed()?;
        best = (next.0, best.1.min(next.1));
    }
    Ok(best)
}

/// Copies of a model in a square, `step` millimetres apart, each with parts of its own.
fn side_by_side(model: &Model, copies: u32, step: f64) -> Model {
    let mut all = Model { parts: Vec::new(), instances: Vec::new(), ..model.clone() };
    let side = f64::from(copies).sqrt().ceil().max(1.0);
    for copy in 0..copies {
        let (row, column) = ((f64::from(copy) / side).floor(), f64::from(copy) % side);
        let moved = DAffine3::from_translation(step * DVec3::new(column, row, 0.0));
        let first = all.parts.len();
        all.parts.extend(model.parts.iter().cloned());
        let place = |instance: &Instance| Instance {
            part: PartId::new(first + instance.part.index()),
            transform: moved * instance.transform,
            ..instance.clone()
        };
        all.instances.extend(model.instances.iter().map(place));
    }
    all
}

impl Scaling {
    /// Whether all numbers of threads give the same last frame, cold and coherent.
    pub(super) fn is_equal(&self) -> bool {
        self.hashes.windows(2).all(|pair| pair[0] == pair[1])
    }

    /// The results as tables.
    pub(super) fn text(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let (cores, processor) = (self.machine.cores, &self.machine.processor);
        let _ = writeln!(text, "{}: {} faces; {cores} cores of {processor}", self.model, self.faces);
        let columns: String = self.threads.iter().map(|threads| format!(" {threads:>22} threads")).collect();
        let _ = writeln!(text, "ms (speedup, serial fraction){columns}");
        for Stage { name, ms, speedup, serial_fraction } in &self.stages {
            let _ = write!(text, "{name:<29}");
            for ((ms, speedup), serial) in ms.iter().zip(speedup).zip(serial_fraction) {
                let serial = serial.map_or_else(|| "    -".to_owned(), |serial| format!("{serial:5.2}"));
                let _ = write!(text, " {ms:>14.3} ({speedup:>6.2}, {serial})");
            }
            text.push('\n');
        }
        for (name, k) in [("cold", 0), ("coherent", 1)] {
            let hashes: String = self.hashes.iter().map(|row| format!(" {:>30}", row[k])).collect();
            let _ = writeln!(text, "{:<29}{hashes}", format!("last {name} frame, hash"));
        }
        let _ = writeln!(text, "last frames: {}", if self.is_equal() { "equal" } else { "NOT EQUAL" });
        self.replayed.iter().for_each(|frames| frames.tell(&mut text));
        let _ = writeln!(text, "as many copies as threads: ms (efficiency)");
        for Weak { threads, faces, prepare_ms, frame_ms, prepare_efficiency, frame_efficiency } in &self.weak {
            let _ = writeln!(
                text,
                "{threads:>3} threads, {faces:>7} faces: prepare {prepare_ms:>9.1} ({prepare_efficiency:.2}), cold frame \
                 {frame_ms:>9.1} ({frame_efficiency:.2})"
            );
        }
        text
    }

    /// Writes the speedups of stages that take their time as a chart.
    pub(super) fn plot(&self, file: &Path, outputs: &mut Outputs) -> Result<(), Failure> {
        plot::page((960, 540), file, outputs, |page| self.draw(page))
    }

    fn draw(&self, area: &plot::Area<'_>) -> plot::Drawn {
        /// Milliseconds on one thread below which a stage is not drawn: it is a matter of waking threads.
        const LEAST: f64 = 0.1;
        let most = self.threads.last().map_or(2.0, |&most| most.max(2) as f64);
        let mut chart = plot::chart(area, format!("{}, {} faces: speedup", self.model, self.faces))
            .build_cartesian_2d((0.9..most * 1.1).log_scale().base(2.0), (0.5..most * 1.1).log_scale().base(2.0))?;
        let label = f64::to_string;
        let mut mesh = chart.configure_mesh();
        mesh.x_desc("threads").y_desc("speedup").x_label_formatter(&label).y_label_formatter(&label);
        mesh.label_style(plot::FONT).light_line_style(TRANSPARENT).draw()?;
        plot::line(&mut chart, "ideal", (BLACK.mix(0.3).into(), 0), [(1.0, 1.0), (most, most)])?;
        let drawn = self.stages.iter().filter(|stage| stage.ms.first().is_some_and(|ms| *ms >= LEAST));
        for (k, stage) in drawn.enumerate() {
            let points = self.threads.iter().zip(&stage.speedup).map(|(&p, &s)| (p as f64, s.max(0.5)));
            plot::line(&mut chart, stage.name, (plot::style(k), 3), points)?;
        }
        plot::legend(&mut chart, SeriesLabelPosition::UpperLeft)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn serial_fractions_are_those_of_amdahl() {
        // A tenth of the work is serial.
        let threads = up_to(12);
        assert_eq!(threads, [1, 2, 4, 8, 12]);
        let ms = threads.iter().map(|&p| 10.0 + 90.0 / p as f64).collect();
        let stage = Stage::of("frame", &threads, ms);
        assert!(stage.serial_fraction[0].is_none() && (stage.speedup[1] - 100.0 / 55.0).abs() < 1e-12);
        assert!(stage.serial_fraction[1..].iter().all(|serial| serial.is_some_and(|f| (f - 0.1).abs() < 1e-12)));
        assert_eq!([up_to(1), up_to(2)], [vec![1], vec![1, 2]]);
    }

    #[test]
    fn copies_have_parts_and_places_of_their_own() {
        let model = trimtess_models::by_name("washer").expect("a model");
        let all = side_by_side(&model, 3, 10.0);
        assert_eq!((all.parts.len(), all.instances.len()), (3 * model.parts.len(), 3 * model.instances.len()));
        let mut places: Vec<_> = all.instances.iter().map(|i| i.transform.translation.to_array()).collect();
        places.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
        places.dedup();
        assert_eq!(places.len(), all.instances.len());
    }
}
