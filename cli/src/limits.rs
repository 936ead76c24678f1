//! `--max-…` on the command line -> the limits of each stage, and messages that name the option to raise. What memory
//! the process took.

use crate::Failure;
use crate::report::Report;
use trimtess::frame::{PlanLimits, PlannerOptions, Shortfall};
use trimtess::import::step::StepOptions;
use trimtess::parallel::SessionOptions;
use trimtess::prepare::{PrepareError, PrepareLimits, PrepareOptions};

/// Limits of cost, and options of reading.
#[derive(Clone, clap::Args)]
#[command(next_help_heading = "Limits (exceeding one is an error, and nothing is written; but see --coarsen)")]
pub(crate) struct LimitArgs {
    /// Maximum file size, bytes.
    #[arg(long, global = true, value_name = "N", default_value_t = StepOptions::DEFAULT.max_bytes)]
    max_bytes: u64,
    /// Maximum number of entities (#n=…) in a file.
    #[arg(long, global = true, value_name = "N", default_value_t = StepOptions::DEFAULT.max_entities)]
    max_entities: u64,
    /// Maximum number of placed parts and assemblies.
    #[arg(long, global = true, value_name = "N", default_value_t = StepOptions::DEFAULT.max_instances)]
    max_instances: u64,
    /// Maximum number of Bézier patches.
    #[arg(long, global = true, value_name = "N", default_value_t = PrepareLimits::DEFAULT.patches)]
    max_patches: u64,
    /// Maximum number of triangles, as counted before meshing: two per lattice cell and two per point of an edge, each
    /// part once. Meshes have about half as many.
    #[arg(long, global = true, value_name = "N", default_value_t = PlanLimits::DEFAULT.triangles)]
    max_triangles: u64,
    /// Maximum number of triangles per tile (a piece of a face), counted in the same way.
    #[arg(long, global = true, value_name = "N", default_value_t = PlanLimits::DEFAULT.triangles_per_tile)]
    max_tile_triangles: u64,
    /// Maximum memory of each stage, MiB, estimated from counts.
    #[arg(long, global = true, value_name = "MIB", default_value_t = StepOptions::DEFAULT.max_memory >> 20)]
    max_memory: u64,
    /// Make a coarser mesh, with a warning, if the tolerance needs more triangles than the limits allow. The coarsest
    /// mesh may still have more.
    #[arg(long, global = true)]
    coarsen: bool,
    /// Also read supplemental geometry (such as construction planes) if it is bounded.
    #[arg(long, global = true, help_heading = "Reading")]
    supplemental: bool,
}

impl LimitArgs {
    fn memory(&self) -> u64 {
        self.max_memory.saturating_mul(1 << 20)
    }

    pub(crate) fn step(&self) -> StepOptions {
        StepOptions::DEFAULT
            .with_max_bytes(self.max_bytes)
            .with_max_entities(self.max_entities)
            .with_max_instances(self.max_instances)
            .with_max_memory(self.memory())
            .with_supplemental(self.supplemental)
    }

    pub(crate) fn prepare(&self) -> PrepareOptions {
        let limits = PrepareLimits::DEFAULT.with_patches(self.max_patches).with_bytes(self.memory());
        PrepareOptions::DEFAULT.with_limits(limits)
    }

    pub(crate) fn plan(&self) -> PlanLimits {
        PlanLimits::DEFAULT
            .with_triangles_per_tile(self.max_tile_triangles)
            .with_triangles(self.max_triangles)
            .with_bytes(self.memory())
    }

    /// Options of a session with these limits of the mesh.
    pub(crate) fn session(&self) -> SessionOptions {
        SessionOptions::DEFAULT.with_planner(PlannerOptions::DEFAULT.with_limits(self.plan()))
    }

    /// Fails if the limits made a plan coarser without `--coarsen`.
    pub(crate) fn check(&self, shortfall: Option<&Shortfall>) -> Result<(), Failure> {
        let short = shortfall.filter(|shortfall| shortfall.by_limits() && !self.coarsen);
        short.map_or(Ok(()), |shortfall| {
            let raise = match (shortfall.unusable, shortfall.memory(), shortfall.density < 1.0) {
                (true, ..) => "",
                (_, Some(_), _) => ", raise --max-memory",
                (_, None, true) => ", raise --max-triangles",
                (_, None, false) => ", raise --max-tile-triangles",
            };
            Err(Failure::Cannot(format!(
                "{shortfall}; use a larger tolerance{raise}, or accept a coarser mesh with --coarsen"
            )))
        })
    }

    /// Warns if the coarsest mesh still has more triangles than allowed.
    pub(crate) fn warn_if_over(&self, triangles: u64, report: &mut Report) {
        if triangles > self.max_triangles {
            let most = self.max_triangles;
            report.add_warning(format!(
                "the coarsest mesh has {triangles} triangles, the limit is {most} (--max-triangles)"
            ));
        }
    }
}

/// Converts an error of preparing. The message names the option to raise.
pub(crate) fn unprepared(error: PrepareError) -> Failure {
    let option = match error {
        PrepareError::TooManyPatches { .. } => "--max-patches",
        PrepareError::TooMuchMemory { .. } => "--max-memory",
        _ => return Failure::cannot(error),
    };
    Failure::Cannot(format!("{error}; raise {option} to continue"))
}

/// Peak resident memory of this process, bytes. `None` where /proc is missing.
pub(crate) fn peak_memory() -> Option<u64> {
    resident("VmHWM:")
}

/// Current resident memory of this process, bytes. `None` where /proc is missing.
pub(crate) fn resident_memory() -> Option<u64> {
    resident("VmRSS:")
}

/// Reads a line in kB of /proc/self/status.
fn resident(what: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(what))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}
