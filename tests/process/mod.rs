//! What a process takes, by Linux. Unknown on other systems.
#![allow(dead_code, reason = "not every test program uses all of it")]

use std::fs;
use std::time::Duration;

/// Peak resident memory of a process (its number, or `self`) so far, bytes; 0 if unknown.
pub(crate) fn peak_of(process: &str) -> u64 {
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib: Option<u64> = line.and_then(|line| line.trim().trim_end_matches(" kB").parse().ok());
    kib.unwrap_or(0) << 10
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
