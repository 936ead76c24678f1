//! docs/diagnostics.md against the kinds of diagnostics; the messages of some.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use trimtess::model::{
    DiagnosticKind, EdgeId, FaceError, FaceId, FaceTrouble, ShellTrouble, StepCause, StepOutcome, StepTrouble,
    TileTrouble,
};

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
