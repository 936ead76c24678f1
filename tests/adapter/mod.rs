//! The graphics adapter of this machine.

use std::sync::OnceLock;
use trimtess::out::wgpu::Renderer;

/// `None`, with a line that says so, where there is no adapter.
///
/// # Panics
/// If the adapter refuses the shaders.
pub(crate) fn renderer() -> Option<&'static Renderer> {
    static RENDERER: OnceLock<Option<Renderer>> = OnceLock::new();
    let made = RENDERER.get_or_init(|| match Renderer::new() {
        Ok(renderer) => {
            println!("drawing with {}", renderer.adapter());
            Some(renderer)
        }
        Err(error) => {
            assert!(!error.to_string().contains("Validation"), "an adapter, but the shaders are wrong: {error}");
            println!("skipped: {error}");
            None
        }
    });
    made.as_ref()
}
