//! This process -> its resident memory.

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
