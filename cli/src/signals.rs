//! SIGINT and SIGTERM -> the process ends by the signal, and no temporary file stays.

/// Starts a thread that waits for signals. Without one, killed runs leave temporary files, and nothing else is wrong.
#[cfg(unix)]
pub(crate) fn watch() {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;
    use signal_hook::low_level::emulate_default_handler;
    // Not SIGHUP: a handler would undo nohup.
    let Ok(mut signals) = Signals::new([SIGINT, SIGTERM]) else { return };
    let wait = move || {
        for signal in signals.forever() {
            trimtess::out::remove_temporaries(|| {
                let _ = emulate_default_handler(signal);
            });
        }
    };
    let _ = std::thread::Builder::new().name("signals".to_owned()).spawn(wait);
}

/// Elsewhere the system removes nothing, and there are no such signals.
#[cfg(not(unix))]
pub(crate) fn watch() {}
