//! `--path` on the command line -> a list of views: a camera path around the model, or recorded in a JSON file.

use crate::Failure;
use crate::input::read_at_most;
use crate::outputs::Outputs;
use clap::builder::{OsStringValueParser, TypedValueParser};
use std::path::{Path, PathBuf};
use trimtess::glam::DVec3;
use trimtess::view::{CameraPath, Picture, View};

/// The `--path` argument.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Route {
    /// A named path.
    Named(CameraPath),
    /// A file of views written by `--save-path`.
    Recorded(PathBuf),
}

/// Parses the name of a path, or else a file name.
pub(crate) fn parser() -> impl TypedValueParser<Value = Route> {
    OsStringValueParser::new().map(|argument| {
        let named = argument.to_str().and_then(|text| text.parse().ok());
        named.map_or_else(|| Route::Recorded(PathBuf::from(argument)), Route::Named)
    })
}

/// Picture options of the command line. Missing ones are taken from the recorded view, or from [`PICTURE`].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PictureOverrides {
    pub(crate) size: Option<(u32, u32)>,
    pub(crate) deviation_px: Option<f64>,
    pub(crate) angle: Option<f64>,
}

/// Defaults. Half a pixel is below what 4× multisampling shows; the angle is the same as in `render`.
const PICTURE: Picture =
    Picture { size: (1920, 1080), deviation_px: 0.5, size_px: None, angle: std::f64::consts::FRAC_PI_6 };

impl Route {
    /// A short name for reports.
    pub(crate) fn name(&self) -> String {
        match self {
            Self::Named(path) => path.name().to_owned(),
            Self::Recorded(file) => file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned(),
        }
    }

    /// The views, at least one: `frames` of a named path (default 300), or of a recorded one (default all, repeated as
    /// needed).
    pub(crate) fn views(
        &self,
        bounds: Option<[DVec3; 2]>,
        frames: Option<usize>,
        asked: PictureOverrides,
    ) -> Result<Vec<View>, Failure> {
        /// Default number of frames, as in the comparison with libGLU.
        const FRAMES: usize = 300;
        let mut views: Vec<View> = match self {
            Self::Named(path) => {
                let bounds =
                    bounds.ok_or_else(|| Failure::Cannot("the model is empty: nothing to fly around".into()))?;
                path.views(bounds, frames.unwrap_or(FRAMES), &PICTURE)
            }
            Self::Recorded(file) => {
                let recorded = read(file)?;
                recorded.iter().cycle().take(frames.unwrap_or(recorded.len())).copied().collect()
            }
        };
        for (k, view) in views.iter_mut().enumerate() {
            view.size = asked.size.unwrap_or(view.size);
            view.deviation_px = asked.deviation_px.unwrap_or(view.deviation_px);
            view.angle = asked.angle.unwrap_or(view.angle);
            if let Self::Recorded(file) = self {
                view.check().map_err(|why| Failure::Cannot(format!("{}: view {k}: {why}", file.display())))?;
            }
        }
        Ok(views)
    }
}

/// Maximum length of a file of views, bytes: about 100 000 of them.
const MOST_BYTES: u64 = 64 << 20;

/// Reads the views of a file, at least one.
fn read(file: &Path) -> Result<Vec<View>, Failure> {
    let cannot = |why: &dyn std::fmt::Display| {
        let known = CameraPath::ALL.iter().map(|path| path.name()).collect::<Vec<_>>().join(", ");
        Failure::Cannot(format!("{}: {why}; --path accepts {known}, or a file written by --save-path", file.display()))
    };
    let text = read_at_most(file, MOST_BYTES).map_err(|e| cannot(&e))?;
    let views: Vec<View> = serde_json::from_slice(&text).map_err(|e| cannot(&e))?;
    if views.is_empty() { Err(cannot(&"the file has no views")) } else { Ok(views) }
}

/// Writes views to a file, one per line.
pub(crate) fn save(views: &[View], file: &Path, outputs: &mut Outputs) -> Result<(), Failure> {
    let rows: Result<Vec<String>, _> = views.iter().map(serde_json::to_string).collect();
    let rows = rows.map_err(|e| Failure::Cannot(format!("{}: {e}", file.display())))?;
    let text = format!("[\n{}\n]\n", rows.join(",\n"));
    outputs.write(file, |out| out.write_all(text.as_bytes()))
}
