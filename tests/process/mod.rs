//! What a process takes, by Linux. Unknown on other systems.
#![allow(dead_code, reason = "not every test program uses all of it")]

use std::fs;
use std::process::{Command, ExitStatus};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Peak resident memory of a process (its number, or `self`) so far, bytes; 0 if unknown.
pub(crate) fn peak_of(process: &str) -> u64 {
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib: Option<u64> = line.and_then(|line| line.trim().trim_end_matches(" kB").parse().ok());
    kib.unwrap_or(0) << 10
}

/// A process that has ended.
pub(crate) struct Ended {
    pub(crate) status: ExitStatus,
    /// Processor time, or wall time if unknown.
    pub(crate) time: Duration,
    /// Peak resident memory until a few milliseconds before the end, bytes; 0 if unknown.
    pub(crate) peak: u64,
}

/// Runs a command. Kills it, and says so, once it has taken more processor time than `most`, or 10 times as much by the
/// clock: machines are busy.
pub(crate) fn watched(command: &mut Command, most: Duration) -> Result<Ended, String> {
    let words = |error: std::io::Error| error.to_string();
    let mut child = command.spawn().map_err(words)?;
    let process = child.id().to_string();
    let (start, mut peak, mut worked) = (Instant::now(), 0, None);
    loop {
        peak = peak.max(peak_of(&process));
        worked = work_of(&process).or(worked);
        let (status, waited) = (child.try_wait().map_err(words)?, start.elapsed());
        if let Some(status) = status {
            return Ok(Ended { status, time: worked.unwrap_or(waited), peak });
        }
        if worked.unwrap_or(waited) > most || waited > 10 * most {
            child.kill().and_then(|()| child.wait()).map_err(words)?;
            return Err(format!("endless: stopped after {waited:.1?}, {worked:?} of work"));
        }
        sleep(Duration::from_millis(2));
    }
}

/// Processor time of all threads of a process (its number, or `self`) so far, if known.
pub(crate) fn work_of(process: &str) -> Option<Duration> {
    /// Linux reports processor time in hundredths of a second.
    const TICK: Duration = Duration::from_millis(10);
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The name, in parentheses, may contain spaces. After it: state, ten other numbers, user time, system time.
    let mut after = stat[stat.rfind(')')? + 1..].split_ascii_whitespace().skip(11);
    let mut ticks = || after.next()?.parse::<u32>().ok();
    Some(TICK * (ticks()? + ticks()?))
}
