//! A panic on one face -> an error of that face, so that a bug in this crate costs no other face.

use crate::model::FaceError;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs `draft` and turns a panic into [`FaceError::Internal`].
pub(crate) fn guarded<T>(draft: impl FnOnce() -> Result<T, FaceError>) -> Result<T, FaceError> {
    catch_unwind(AssertUnwindSafe(draft)).unwrap_or_else(|panic| Err(FaceError::Internal(panic_message(&*panic))))
}

/// The message of a panic, or a placeholder if the payload is not text.
pub(crate) fn panic_message(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().copied();
    text.or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("a panic without a text").to_owned()
}
