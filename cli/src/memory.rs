//! This process -> how much memory it takes.

/// Largest resident size of this process so far.
pub(crate) fn peak_memory() -> Option<u64> {
    resident("VmHWM:")
}

/// Resident size of this process now.
pub(crate) fn resident_memory() -> Option<u64> {
    resident("VmRSS:")
}

/// A number of the kernel's account of this process.
fn resident(what: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(what))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}
