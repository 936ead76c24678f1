//! `trimtess` for browsers: STEP files to meshes and pictures, on one thread of the caller's, usually a web worker.
//!
//! `docs/web.md` has the interface with examples; `web/js` wraps it. Empty for other targets than wasm32.
#![cfg(target_arch = "wasm32")]
#![allow(unreachable_pub, reason = "wasm-bindgen exports public items only")]

mod progress;

mod diagnostic;

mod limits;

mod instance;

mod mesh;

mod model;

mod share;

mod canvas;

mod looks;

mod show;

mod viewer;

use std::fmt::Display;
use wasm_bindgen::JsError;
use wasm_bindgen::prelude::wasm_bindgen;

/// Runs when the module is instantiated.
#[wasm_bindgen(start)]
fn start() {
    console_error_panic_hook::set_once();
}

/// An error of the library, in its words.
fn told(error: impl Display) -> JsError {
    JsError::new(&error.to_string())
}
