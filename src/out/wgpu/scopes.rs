//! Errors of the device -> errors of the calls that caused them.

use super::error::RenderError;
use ::wgpu::{Error, ErrorFilter};
use std::fmt;
use std::future::Future;
use std::pin::Pin;
use std::sync::{Mutex, PoisonError};
use std::task::{Context, Poll, Waker};

type Answer = Pin<Box<dyn Future<Output = Option<Error>> + Send>>;

/// Errors that the device has still to tell. Natively it answers at once. In browsers it answers between calls, so that
/// the error of a call is returned by a later one.
#[derive(Default)]
pub(super) struct Scopes(Mutex<Vec<Answer>>);

impl Scopes {
    /// Runs `work` and returns the device errors it causes. Without error scopes wgpu would panic on them.
    pub(super) fn checked<T>(
        &self,
        device: &::wgpu::Device,
        work: impl FnOnce(&::wgpu::Device) -> T,
    ) -> Result<T, RenderError> {
        let memory = device.push_error_scope(ErrorFilter::OutOfMemory);
        let validation = device.push_error_scope(ErrorFilter::Validation);
        let internal = device.push_error_scope(ErrorFilter::Internal);
        let made = work(device);
        let (internal, validation, memory) = (internal.pop(), validation.pop(), memory.pop());
        let mut awaited = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // A failed allocation causes validation errors later on: report the cause first.
        let answers: [Answer; 3] = [Box::pin(memory), Box::pin(internal), Box::pin(validation)];
        awaited.extend(answers);
        let mut found = None;
        awaited.retain_mut(|answer| match answer.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(error) => {
                found = found.take().or(error);
                false
            }
            Poll::Pending => true,
        });
        found.map_or(Ok(made), |error| Err(RenderError::Device(error.to_string())))
    }
}

impl fmt::Debug for Scopes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Scopes")
    }
}
