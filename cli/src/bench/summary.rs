//! Flights and replays -> the report: JSON for programs, tables for people.

use super::flight::{Flight, FrameOutput, Times};
use super::replay::{EPOCH, Policy};
use crate::name_of;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Median and 99th percentile, in the unit of the numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(super) struct Percentiles {
    pub(super) p50: f64,
    pub(super) p99: f64,
}

impl Percentiles {
    /// Computes both. Zero for no numbers.
    pub(super) fn of(numbers: impl IntoIterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = numbers.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        // The smallest number that is at least as large as this share of all numbers.
        let rank = |share: f64| ((share * sorted.len() as f64).ceil() as usize).max(1) - 1;
        let at = |share: f64| sorted.get(rank(share)).copied().unwrap_or(0.0);
        Self { p50: at(0.5), p99: at(0.99) }
    }
}

/// All measurements.
#[derive(Serialize)]
pub(super) struct Report {
    pub(super) model: String,
    pub(super) machine: Machine,
    pub(super) tiles: usize,
    /// Width and height, pixels.
    pub(super) size: (u32, u32),
    pub(super) deviation_px: f64,
    pub(super) angle_deg: f64,
    pub(super) runs: Vec<Run>,
    #[serde(rename = "replay", skip_serializing_if = "Vec::is_empty")]
    pub(super) replays: Vec<Replay>,
}

/// The machine that the measurements were made on.
#[derive(Serialize)]
pub(super) struct Machine {
    pub(super) processor: String,
    pub(super) cores: usize,
    pub(super) system: &'static str,
}

impl Machine {
    pub(super) fn this() -> Self {
        let cpuinfo = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let model = cpuinfo.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
        Self {
            processor: model.map_or_else(|| std::env::consts::ARCH.to_owned(), |(_, name)| name.trim().to_owned()),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            system: std::env::consts::OS,
        }
    }
}

/// Results of a path flown with one set of options.
#[derive(Serialize)]
pub(super) struct Run {
    pub(super) path: String,
    pub(super) workers: usize,
    /// What frames reuse: a name of `Coherence`.
    pub(super) coherence: String,
    pub(super) frames: usize,
    pub(super) frames_per_s: f64,
    /// Time of a frame, from the view to the end of the commit.
    pub(super) p50_ms: f64,
    pub(super) p99_ms: f64,
    /// The first frame, which is always whole.
    pub(super) first_ms: f64,
    /// Processor time of a frame, milliseconds: the caller's plus the maximum of the workers.
    pub(super) undisturbed_ms: Percentiles,
    pub(super) triangles_mean: f64,
    pub(super) tiles_remade_mean: f64,
    pub(super) bytes_uploaded_mean: f64,
    /// Maximum bytes that a renderer holds.
    pub(super) bytes_held: u64,
    pub(super) bytes_held_per_triangle: f64,
    /// Mean over maximum processor time of the workers, both summed over frames.
    pub(super) efficiency: f64,
    pub(super) stages_ms: Stages,
    /// Resident memory of the process after the first and the last frame, if known.
    pub(super) resident_bytes: [Option<u64>; 2],
    pub(super) seconds: f64,
}

/// Times of the stages of a frame, milliseconds.
#[derive(Serialize)]
pub(super) struct Stages {
    /// From the view to the plan, on the master.
    pub(super) plan: Percentiles,
    /// From the plan to the last delivery.
    pub(super) make: Percentiles,
    /// From the last delivery to the end of the commit to the sink.
    pub(super) commit: Percentiles,
    /// Busy time of each worker.
    pub(super) workers: Vec<Percentiles>,
    /// Processor time of each worker.
    pub(super) workers_cpu: Vec<Percentiles>,
    /// Plan and commit.
    pub(super) around: Percentiles,
}

impl Run {
    pub(super) fn of(flight: &Flight, path: String) -> Self {
        let Flight { times, made, .. } = flight;
        let frames = times.len();
        let all = |of: fn(&Times) -> f64| Percentiles::of(times.iter().map(of));
        let mean = |of: fn(&FrameOutput) -> u64| made.iter().map(|m| of(m) as f64).sum::<f64>() / frames.max(1) as f64;
        let whole = all(|t| t.frame);
        let each = |of: fn(&Times) -> &[f64]| {
            let worker = |w: usize| Percentiles::of(times.iter().map(|t| of(t)[w]));
            (0..flight.workers).map(worker).collect::<Vec<_>>()
        };
        let most = made.iter().map(|m| m.held).max_by_key(|held| held.bytes).unwrap_or_default();
        let seconds: f64 = 1e-3 * times.iter().map(|t| t.frame).sum::<f64>();
        Self {
            path,
            workers: flight.workers,
            coherence: name_of(&flight.coherence),
            frames,
            frames_per_s: if seconds > 0.0 { frames as f64 / seconds } else { 0.0 },
            p50_ms: whole.p50,
            p99_ms: whole.p99,
            first_ms: times.first().map_or(0.0, |t| t.frame),
            undisturbed_ms: all(Times::undisturbed),
            triangles_mean: mean(|m| m.held.triangles),
            tiles_remade_mean: mean(|m| m.tiles),
            bytes_uploaded_mean: mean(|m| m.uploaded),
            bytes_held: most.bytes,
            bytes_held_per_triangle: most.bytes as f64 / (most.triangles as f64).max(1.0),
            efficiency: efficiency(times),
            stages_ms: Stages {
                plan: all(|t| t.plan),
                make: all(|t| t.make),
                commit: all(|t| t.commit),
                workers: each(|t| &t.busy),
                workers_cpu: each(|t| &t.cpu),
                around: all(|t| t.around),
            },
            resident_bytes: flight.resident,
            seconds: flight.seconds,
        }
    }
}

/// Mean over maximum processor time of workers, both summed over frames; 1 if no work was done.
fn efficiency(times: &[Times]) -> f64 {
    let mean: f64 = times.iter().map(|t| t.cpu.iter().sum::<f64>() / t.cpu.len() as f64).sum();
    let most: f64 = times.iter().map(|t| t.cpu.iter().copied().fold(0.0, f64::max)).sum();
    if most > 0.0 { mean / most } else { 1.0 }
}

/// Simulation of any number of workers from the measured costs of tiles.
#[derive(Serialize)]
pub(super) struct Replay {
    /// What frames reuse: `off` or `on`.
    pub(super) coherence: String,
    /// Frames in which tiles were timed.
    pub(super) frames: usize,
    /// Cost of a tile in a frame, microseconds.
    pub(super) tile_us: TileCosts,
    /// The most expensive tiles, worst first.
    pub(super) costly: Vec<Costly>,
    pub(super) rows: Vec<Row>,
}

/// Costs of tiles, microseconds.
#[derive(Serialize)]
pub(super) struct TileCosts {
    pub(super) mean: f64,
    #[serde(flatten)]
    pub(super) spread: Percentiles,
    pub(super) most: f64,
}

/// An expensive tile.
#[derive(Serialize)]
pub(super) struct Costly {
    pub(super) part: u32,
    pub(super) face: u32,
    pub(super) tile: u32,
    /// The face's entity in the file; 0 if unknown.
    pub(super) entity: u64,
    /// Cost in the frame where it is highest, microseconds.
    pub(super) us: f64,
    /// Fraction of the work of that frame.
    pub(super) share: f64,
}

/// Results for one number of workers.
#[derive(Serialize)]
pub(super) struct Row {
    pub(super) workers: usize,
    /// Mean over maximum load, by name of the [`Policy`].
    pub(super) efficiency: BTreeMap<&'static str, f64>,
}

impl Report {
    /// The results as tables.
    pub(super) fn text(&self) -> String {
        let mut text = String::new();
        let Self { model, tiles, size: (width, height), deviation_px, angle_deg, machine, .. } = self;
        let Machine { cores, processor, .. } = machine;
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{model}: {tiles} tiles; {width} × {height} pixels, {deviation_px} px, {angle_deg:.0}°; {cores} cores of \
             {processor}"
        );
        let _ = writeln!(
            text,
            "cpu: plan, commit, and the longest processor time of a worker, as on an otherwise idle machine"
        );
        let _ = writeln!(
            text,
            "path     workers    coherence | frames/s  ms: p50    p99  first | cpu: p50    p99 | \
             plan p50    p99 | slowest worker | sink p50    p99 | \
             triangles   tiles made   KiB sent | efficiency"
        );
        self.runs.iter().for_each(|run| text += &run.line());
        self.replays.iter().for_each(|replay| replay.tell(&mut text));
        text
    }
}

impl Run {
    fn line(&self) -> String {
        let Self { path, workers, coherence, frames_per_s, p50_ms, p99_ms, first_ms, efficiency, .. } = self;
        let Self { triangles_mean, tiles_remade_mean: tiles, bytes_uploaded_mean, .. } = self;
        let Stages { plan, commit, workers: of_workers, .. } = &self.stages_ms;
        let slowest = of_workers.iter().copied().max_by(|a, b| a.p50.total_cmp(&b.p50)).unwrap_or_default();
        let [cpu, plan, slowest, sink] = [(self.undisturbed_ms, 8), (*plan, 8), (slowest, 7), (*commit, 8)]
            .map(|(Percentiles { p50, p99 }, width)| format!("{p50:>width$.3} {p99:>6.2}"));
        let sent = bytes_uploaded_mean / 1024.0;
        format!(
            "{path:<10} {workers:>5} {coherence:>12} | {frames_per_s:>8.1}  {p50_ms:>7.3} {p99_ms:>6.2} {first_ms:>6.2} | \
             {cpu} | {plan} | {slowest} | {sink} | {triangles_mean:>9.0} {tiles:>12.1} {sent:>10.1} | \
             {efficiency:>10.3}\n"
        )
    }
}

impl Replay {
    fn tell(&self, text: &mut String) {
        let TileCosts { mean, spread, most } = &self.tile_us;
        let _ = writeln!(
            text,
            "simulated from the costs of tiles in {} frames, coherence {}: {mean:.1} µs per tile, median {:.1}, \
             99 % {:.1}, max {most:.1}",
            self.frames, self.coherence, spread.p50, spread.p99
        );
        let _ = write!(text, "workers |");
        Policy::ALL.iter().for_each(|(name, _)| {
            let _ = write!(text, " {name:>10}");
        });
        text.push('\n');
        for row in &self.rows {
            let _ = write!(text, "{:>7} |", row.workers);
            Policy::ALL.iter().for_each(|(name, _)| {
                let _ = write!(text, " {:>10.3}", row.efficiency.get(name).copied().unwrap_or(0.0));
            });
            text.push('\n');
        }
        let _ = writeln!(
            text,
            "epoch: rebalanced by cost every {EPOCH} frames; dynamic: nearly the best way to deal whole tiles"
        );
        for tile in &self.costly {
            let Costly { part, face, tile, entity, us, share } = tile;
            let percent = 100.0 * share;
            let number = if *entity == 0 { String::new() } else { format!(" (#{entity})") };
            let _ = writeln!(
                text,
                "  part {part} face {face}{number} tile {tile}: {us:.0} µs, {percent:.1} % of its frame"
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_elements_of_the_sample() {
        assert_eq!(Percentiles::of([]), Percentiles { p50: 0.0, p99: 0.0 });
        assert_eq!(Percentiles::of([3.0]), Percentiles { p50: 3.0, p99: 3.0 });
        assert_eq!(Percentiles::of((1..=100).rev().map(f64::from)), Percentiles { p50: 50.0, p99: 99.0 });
        assert_eq!(Percentiles::of((1..=300).map(f64::from)), Percentiles { p50: 150.0, p99: 297.0 });
    }

    #[test]
    fn efficiency_is_over_all_frames() {
        let times = |cpu: &[f64]| Times { cpu: cpu.to_vec(), ..Times::default() };
        assert!((efficiency(&[times(&[2.0, 2.0]), times(&[4.0, 0.0])]) - 4.0 / 6.0).abs() < 1e-12);
        assert_eq!(efficiency(&[times(&[0.0])]), 1.0);
    }
}
