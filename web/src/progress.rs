//! Progress of long work -> a callback of JavaScript.

use js_sys::Function;
use std::cell::RefCell;
use trimtess::control::Control;
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const PROGRESS: &str = r#"
/** Hears of long work while it runs. What it throws is ignored. */
export type Progress = (stage: "read" | "prepare" | "tessellate", done: number, total: number) => void;
"#;

#[wasm_bindgen]
extern "C" {
    /// A callback.
    #[wasm_bindgen(extends = Function, typescript_type = "Progress")]
    pub type Progress;
}

thread_local! {
    /// The callback of the stage that runs. Observers may be called on any thread, and so cannot hold it.
    static CALLBACK: RefCell<Option<Function>> = const { RefCell::new(None) };
}

/// A control that calls `progress`, until the next control is made.
pub(crate) fn control(progress: Option<Progress>) -> Control {
    let heard = progress.is_some();
    CALLBACK.set(progress.map(|callback| callback.unchecked_into()));
    if !heard {
        return Control::default();
    }
    Control::observed_by(|progress| {
        let callback = CALLBACK.with_borrow(Clone::clone);
        if let Some(callback) = callback {
            let [done, total] = [progress.done, progress.total].map(|count| JsValue::from(count as f64));
            // The callback's own failure does not concern the work.
            let _ = callback.call3(&JsValue::NULL, &JsValue::from(progress.stage.name()), &done, &total);
        }
    })
}
