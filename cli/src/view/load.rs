//! A file to a prepared model and its session, on a separate thread so that the window stays responsive.

use crate::input::Input;
use crate::limits::{LimitArgs, unprepared};
use crate::{Common, Failure};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;
use std::time::Instant;
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::{PrepareOptions, Prepared, prepare};

/// Loads files.
#[derive(Clone)]
pub(super) struct Loader {
    pub(super) limits: LimitArgs,
    prepare: PrepareOptions,
    /// Number of threads; 0 for one per core.
    threads: usize,
}

/// A loaded model.
pub(super) struct Loaded {
    pub(super) name: String,
    pub(super) prepared: Arc<Prepared>,
    pub(super) session: Session,
    pub(super) seconds: f64,
}

/// A file that is being loaded.
pub(super) struct Loading {
    pub(super) name: String,
    pub(super) since: Instant,
    result: Receiver<Result<Loaded, String>>,
}

impl Loader {
    pub(super) fn new(common: &Common) -> Self {
        Self { limits: common.limits.clone(), prepare: common.prepare(), threads: common.workers() }
    }

    /// Loads a file on this thread and its rayon pool.
    pub(super) fn load(&self, input: &Input, session: &SessionOptions) -> Result<Loaded, Failure> {
        let start = Instant::now();
        let model = input.read(&self.limits.step())?;
        let prepared = Arc::new(prepare(model, &self.prepare).map_err(unprepared)?);
        let session = Session::start(Arc::clone(&prepared), session).map_err(Failure::cannot)?;
        Ok(Loaded { name: input.name(), prepared, session, seconds: start.elapsed().as_secs_f64() })
    }

    /// Starts loading a file on another thread.
    pub(super) fn start(&self, input: Input, session: &SessionOptions) -> Loading {
        let (sender, result) = channel();
        let refused = sender.clone();
        let (loader, session, name) = (self.clone(), session.clone(), input.name());
        let work = move || {
            // A separate pool: the window's thread is a worker of the global one.
            let pool = rayon::ThreadPoolBuilder::new().num_threads(loader.threads).build();
            let loaded = match pool {
                Ok(pool) => pool.install(|| loader.load(&input, &session)).map_err(|failure| failure.to_string()),
                Err(error) => Err(error.to_string()),
            };
            // Fails if the window was closed meanwhile.
            let _ = sender.send(loaded);
        };
        if let Err(error) = thread::Builder::new().name("trimtess-load".into()).spawn(work) {
            // Cannot fail: the receiver is here.
            let _ = refused.send(Err(format!("cannot start a thread: {error}")));
        }
        Loading { name, since: Instant::now(), result }
    }
}

impl Loading {
    /// The result, once loading has ended.
    pub(super) fn poll(&self) -> Option<Result<Loaded, String>> {
        match self.result.try_recv() {
            Ok(loaded) => Some(loaded),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => {
                Some(Err("internal error while reading the file; see the terminal".into()))
            }
        }
    }
}
