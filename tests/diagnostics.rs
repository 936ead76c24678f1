//! docs/diagnostics.md against the kinds of diagnostics; the messages of some, and of errors with a cause.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeSet;
use std::error::Error;
use std::fs;
use std::io;
use std::path::Path;
use trimtess::mesh::{GridTooCoarse, SinkError};
use trimtess::model::{
    DiagnosticKind, EdgeId, FaceError, FaceId, FaceTrouble, ModelError, PartError, PartId, ShellTrouble, SplineError,
    StepCause, StepOutcome, StepTrouble, SurfaceError, TileId, TileTrouble, TrimError,
};
use trimtess::parallel::FrameError;
use trimtess::view::InvalidView;

/// Codes that only the program reports.
const OF_THE_PROGRAM: [&str; 4] = ["check-failed", "plan-coarser", "face-rounded-away", "triangles-rounded-away"];

#[test]
fn the_table_has_each_code_once_and_nothing_else() {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/diagnostics.md")).unwrap();
    let rows: Vec<Vec<&str>> = text
        .lines()
        .filter(|line| line.starts_with("| `"))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    let told: Vec<&str> = rows.iter().map(|row| row[0].trim_matches('`')).collect();
    let known: Vec<&str> = DiagnosticKind::codes().into_iter().chain(OF_THE_PROGRAM).collect();
    let sets = [&told, &known].map(|codes| codes.iter().copied().collect::<BTreeSet<_>>());
    assert_eq!(sets[0].len(), told.len(), "a code has two rows");
    assert_eq!(sets[1].len(), known.len(), "two kinds have one code");
    assert_eq!(sets[0].symmetric_difference(&sets[1]).collect::<Vec<_>>(), Vec::<&&str>::new());
    for row in rows {
        let severities = ["note", "warning", "error"];
        assert!(row.len() == 4 && severities.iter().any(|s| row[1].starts_with(s)) && row[2].ends_with('.'), "{row:?}");
    }
}

#[test]
fn codes_are_kebab_case() {
    let is_kebab =
        |code: &str| code.split('-').all(|word| !word.is_empty() && word.bytes().all(|b| b.is_ascii_lowercase()));
    let bad: Vec<&str> = DiagnosticKind::codes().into_iter().filter(|code| !is_kebab(code)).collect();
    assert!(bad.is_empty(), "{bad:?}");
}

#[test]
fn messages_are_formatted_from_the_kind() {
    let not_in_file = |entity| StepCause { entity, trouble: Box::new(StepTrouble::NotInFile { entity: 7 }) };
    let filled = FaceTrouble::Filled { cause: FaceError::Refused(not_in_file(None)), area_mm2: 4.0 };
    let not_orientable = ShellTrouble::NotOrientable { edges: 2, edge: EdgeId(5), faces: [FaceId(1), FaceId(3)] };
    let cases: [(DiagnosticKind, &str, &str); 5] = [
        (
            filled.into(),
            "face-surface-not-read",
            "the surface was not read: #7 is referred to but not in the file; its loops are filled in space, with about 4.000e0 mm²",
        ),
        (
            StepOutcome::FaceLeftOut(not_in_file(Some(6))).into(),
            "step-face-left-out",
            "face left out: #6: #7 is referred to but not in the file",
        ),
        (
            StepOutcome::LeftOut(StepTrouble::NotRead { what: "curves", keyword: "CLOTHOID".to_owned() }).into(),
            "step-type-not-read",
            "curves of type CLOTHOID are not read",
        ),
        (
            not_orientable.into(),
            "shell-not-orientable",
            "2 edges cannot be oriented: their faces run along them the same way, however they are flipped; the first is edge 5 of \
             faces 1 and 3",
        ),
        (
            DiagnosticKind::Tile { first: TileTrouble::Empty, others: 2 },
            "tile-empty",
            "nothing is left of the face at this tolerance; 2 more tiles like it",
        ),
    ];
    for (kind, code, words) in cases {
        assert_eq!((kind.code(), kind.to_string().as_str()), (code, words));
    }
}

/// Errors that have a cause, of each kind that can be made from outside.
fn errors_with_a_cause() -> Vec<Box<dyn Error>> {
    let full = || io::Error::other("full");
    let (spline, face) = (SplineError::Degree { degree: 0 }, FaceId(2));
    let surface = SurfaceError::Spline { direction: 'u', error: spline };
    let part = PartError::Surface { face, error: surface };
    let trim = TrimError::Spline { piece: 1, error: spline };
    let unsound = |error: SurfaceError| StepCause { entity: Some(6), trouble: Box::new(error.into()) };
    let grid = GridTooCoarse { part: PartId(0), tile: TileId(1), moved: 1e-3, chord: 1e-4 };
    let diagnostics: [DiagnosticKind; 3] = [
        StepOutcome::FaceLeftOut(unsound(surface)).into(),
        FaceTrouble::Unusable(FaceError::Surface(surface)).into(),
        FaceTrouble::Filled { cause: FaceError::Refused(unsound(surface)), area_mm2: 4.0 }.into(),
    ];
    let mut errors: Vec<Box<dyn Error>> = diagnostics.into_iter().map(Into::into).collect();
    errors.extend::<[Box<dyn Error>; 9]>([
        SinkError::new("a.obj", full()).into(),
        FrameError::from(SinkError::new("a.obj", full())).into(),
        FrameError::from(grid).into(),
        FrameError::View { view: 1, why: InvalidView::Size { width: 0, height: 4 } }.into(),
        SurfaceError::Curve(spline).into(),
        ModelError::Part { part: PartId(0), error: part }.into(),
        PartError::Trim { face, curve: 3, error: trim }.into(),
        FaceError::Trim { curve: 3, error: trim }.into(),
        StepTrouble::from(part).into(),
    ]);
    #[cfg(feature = "step")]
    errors.extend(errors_of_reading());
    errors
}

#[cfg(feature = "step")]
fn errors_of_reading() -> [Box<dyn Error>; 2] {
    use trimtess::import::step::{StepError, StepOptions, read};
    let options = StepOptions::DEFAULT.with_max_syntax_repairs(0);
    let io = StepError::Io { path: "a.step".into(), error: io::Error::other("no such disk") };
    [io.into(), read(b"ISO-10303-21;HEADER;ENDSEC;DATA;#1=A('", &options).unwrap_err().into()]
}

#[test]
fn no_message_is_in_the_chain_of_an_error_twice() {
    for error in errors_with_a_cause() {
        let mut chain = vec![error.to_string()];
        let mut cause = error.source();
        while let Some(error) = cause {
            chain.push(error.to_string());
            cause = error.source();
        }
        let twice = chain.iter().enumerate().any(|(k, outer)| chain[k + 1..].iter().any(|inner| outer.contains(inner)));
        assert!(!twice, "{chain:?}");
    }
}

/// What no sample can show, such as the error of a system that refuses threads.
#[test]
fn only_transparent_errors_have_a_source() {
    fn sources(folder: &Path, bad: &mut Vec<String>) {
        for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if entry.is_dir() {
                sources(&entry, bad);
            } else if entry.extension().is_some_and(|extension| extension == "rs") {
                let text = fs::read_to_string(&entry).unwrap();
                let mut of_variant = "";
                for line in text.lines().map(str::trim_start) {
                    if line.starts_with("#[error(") {
                        of_variant = line;
                    }
                    let is_source = line.contains("#[source]") || line.contains("#[from]");
                    if is_source && of_variant != "#[error(transparent)]" {
                        bad.push(format!("{}: {line}", entry.display()));
                    }
                }
            }
        }
    }
    let mut bad = Vec::new();
    sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut bad);
    assert!(bad.is_empty(), "{bad:#?}");
}
