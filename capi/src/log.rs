//! What the library tells of its work -> a callback.

use crate::border::{User, entry};
use crate::status::{Failure, tt_status, without_nul};
use std::cell::Cell;
use std::ffi::{c_char, c_void};
use std::fmt::{self, Write as _};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{PoisonError, RwLock};
use tracing::field::{Field, Visit};
use tracing::level_filters::LevelFilter;
use tracing::span::{Attributes, Id, Record};
use tracing::subscriber::set_global_default;
use tracing::{Event, Level, Metadata, Subscriber};

/// How much is told.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum tt_log_level {
    TT_LOG_OFF = 0,
    /// Errors.
    TT_LOG_ERROR = 1,
    /// And warnings.
    TT_LOG_WARN = 2,
    /// And what happens once per call.
    TT_LOG_INFO = 3,
    /// And the stages of each frame.
    TT_LOG_DEBUG = 4,
    /// And what happens in each tile.
    TT_LOG_TRACE = 5,
}

type Log = extern "C" fn(user: *mut c_void, level: u32, text: *const c_char);

/// Calls are made while this is read, so that none is in progress once another callback is set.
static LOG: RwLock<Option<(Log, User)>> = RwLock::new(None);

static LEVEL: AtomicU32 = AtomicU32::new(0);

thread_local! {
    /// Whether this thread is within the callback.
    static WITHIN: Cell<bool> = const { Cell::new(false) };
}

/// Sets the process's log callback, and the level up to which it is called (`tt_log_level`). Null, or TT_LOG_OFF, ends
/// the log; once this returns, the callback before is not called any more.
///
/// The callback runs on any thread, on several at the same time. It returns at once and makes no `tt_` call. `text` is
/// UTF-8 and valid during the callback.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_set_log(
    level: u32,
    log: Option<extern "C" fn(user: *mut c_void, level: u32, text: *const c_char)>,
    user: *mut c_void,
) -> tt_status {
    entry!(_c => {
        if !LEVELS.iter().any(|&(known, _)| known as u32 == level) {
            return Err(Failure::argument(format!("no log level {level}")));
        }
        if WITHIN.get() {
            return Err(Failure::busy("a log callback cannot set another one"));
        }
        // There is one for the whole process: this one, unless a Rust program that links the library has its own.
        let _ = set_global_default(Forward);
        let mut set = LOG.write().unwrap_or_else(PoisonError::into_inner);
        *set = log.filter(|_| level > 0).map(|log| (log, User::of(user)));
        LEVEL.store(if set.is_some() { level } else { 0 }, Ordering::Relaxed);
        drop(set);
        tracing::callsite::rebuild_interest_cache();
        Ok(())
    })
}

const LEVELS: [(tt_log_level, LevelFilter); 6] = [
    (tt_log_level::TT_LOG_OFF, LevelFilter::OFF),
    (tt_log_level::TT_LOG_ERROR, LevelFilter::ERROR),
    (tt_log_level::TT_LOG_WARN, LevelFilter::WARN),
    (tt_log_level::TT_LOG_INFO, LevelFilter::INFO),
    (tt_log_level::TT_LOG_DEBUG, LevelFilter::DEBUG),
    (tt_log_level::TT_LOG_TRACE, LevelFilter::TRACE),
];

fn number(level: Level) -> u32 {
    let known = LEVELS.iter().find(|&&(_, filter)| filter == level);
    known.map_or(0, |&(number, _)| number as u32)
}

fn tell(level: Level, text: String) {
    if WITHIN.replace(true) {
        return;
    }
    if let Some((log, user)) = *LOG.read().unwrap_or_else(PoisonError::into_inner) {
        log(user.get(), number(level), without_nul(text).as_ptr());
    }
    WITHIN.set(false);
}

/// Passes events on, and the beginning of spans.
struct Forward;

impl Subscriber for Forward {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        number(*metadata.level()) <= LEVEL.load(Ordering::Relaxed)
    }

    fn max_level_hint(&self) -> Option<LevelFilter> {
        let level = LEVEL.load(Ordering::Relaxed);
        LEVELS.iter().find(|&&(known, _)| known as u32 == level).map(|&(_, filter)| filter)
    }

    fn new_span(&self, span: &Attributes<'_>) -> Id {
        let mut text = Text(span.metadata().name().to_owned());
        span.record(&mut text);
        tell(*span.metadata().level(), text.0);
        // Spans are told when they begin, and not told apart afterwards.
        Id::from_u64(1)
    }

    fn record(&self, _: &Id, _: &Record<'_>) {}

    fn record_follows_from(&self, _: &Id, _: &Id) {}

    fn event(&self, event: &Event<'_>) {
        let mut text = Text(String::new());
        event.record(&mut text);
        tell(*event.metadata().level(), text.0);
    }

    fn enter(&self, _: &Id) {}

    fn exit(&self, _: &Id) {}
}

/// The message, then the fields as `name=value`.
struct Text(String);

impl Visit for Text {
    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        let gap = if self.0.is_empty() { "" } else { " " };
        let name = if field.name() == "message" { String::new() } else { format!("{}=", field.name()) };
        // Writing to a string does not fail.
        let _ = write!(self.0, "{gap}{name}{value:?}");
    }
}
