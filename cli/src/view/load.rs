//! A file to a model with its session, on a thread of its own: the window goes on meanwhile.

use crate::Common;
use crate::input::Input;
use crate::limits::{LimitArgs, unprepared};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;
use std::time::Instant;
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::{PrepareOptions, Prepared, prepare};

/// How files are read.
#[derive(Clone)]
pub(super) struct Loader {
    limits: LimitArgs,
    prepare: PrepareOptions,
    /// Threads for it; 0 = one per core.
    threads: usize,
}

/// A model that can be shown.
pub(super) struct Loaded {
    pub(super) name: String,
    pub(super) prepared: Arc<Prepared>,
    pub(super) session: Session,
    pub(super) seconds: f64,
}

/// A file that is being read.
pub(super) struct Loading {
    pub(super) name: String,
    pub(super) since: Instant,
    result: Receiver<Result<Loaded, String>>,
}

impl Loader {
    pub(super) fn new(common: &Common) -> Self {
        Self { limits: common.limits.clone(), prepare: common.prepare(), threads: common.workers() }
    }

    /// Reads and prepares, on this thread and the pool that it is in.
    pub(super) fn load(&self, input: &Input, session: &SessionOptions) -> Result<Loaded, String> {
        let start = Instant::now();
        let model = input.read(&self.limits.step()).map_err(|failure| failure.to_string())?;
        let prepared = Arc::new(prepare(model, &self.prepare).map_err(|error| unprepared(error).to_string())?);
        let session = Session::start(Arc::clone(&prepared), session).map_err(|error| error.to_string())?;
        Ok(Loaded { name: input.name(), prepared, session, seconds: start.elapsed().as_secs_f64() })
    }

    /// The same on another thread.
    pub(super) fn start(&self, input: Input, session: &SessionOptions) -> Loading {
        let (sender, result) = channel();
        let (loader, session, name) = (self.clone(), session.clone(), input.name());
        let work = move || {
            // A pool of its own: the process's has the window's thread for one of its workers.
            let pool = rayon::ThreadPoolBuilder::new().num_threads(loader.threads).build();
            let loaded = match pool {
                Ok(pool) => pool.install(|| loader.load(&input, &session)),
                Err(error) => Err(error.to_string()),
            };
            // A window that was closed meanwhile does not listen.
            let _ = sender.send(loaded);
        };
        // A thread that is refused hangs up, as one that panics does.
        let _ = thread::Builder::new().name("trimtess-load".into()).spawn(work);
        Loading { name, since: Instant::now(), result }
    }
}

impl Loading {
    /// What came of it, once it has ended.
    pub(super) fn poll(&self) -> Option<Result<Loaded, String>> {
        match self.result.try_recv() {
            Ok(loaded) => Some(loaded),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => {
                Some(Err("internal error while reading it; the terminal says more".into()))
            }
        }
    }
}
