//! Reference facts about the files of a corpus: its reference.jsonl and exceptions.json.

use crate::folder::beside_the_checkout;
use std::path::{Path, PathBuf};

/// The value of a key in one line of JSON, up to the next comma or bracket.
pub(crate) fn value<'a>(line: &'a str, key: &str) -> Option<&'a str> {
    let start = line.find(&format!("\"{key}\": "))? + key.len() + 4;
    let rest = &line[start..];
    Some(rest[..rest.find([',', '}']).unwrap_or(rest.len())].trim_matches(['"', '[', ']']))
}

/// Names and facts of the STEP files in the reference.
fn step_lines(reference: &str) -> impl Iterator<Item = (&str, &str)> {
    reference
        .lines()
        .filter_map(|line| Some((value(line, "file")?, line)))
        .filter(|(file, _)| Path::new(file).extension().is_some_and(|e| e == "stp" || e == "step"))
}

/// A folder of real files and its reference facts.
pub(crate) struct Corpus {
    pub(crate) path: PathBuf,
    /// Name and facts of each STEP file in its reference.jsonl.
    pub(crate) files: Vec<(String, String)>,
    exceptions: String,
}

/// Folders beside the checkout, and their numbers of STEP files.
const FOLDERS: [(&str, usize); 2] = [("../shared/corpus", 39), ("../shared/corpus-closed", 12)];

/// The corpora that exist. Prints which are absent.
pub(crate) fn corpora() -> Vec<Corpus> {
    let read = |(folder, count): (&str, usize)| {
        let path = beside_the_checkout(folder)?;
        let reference = std::fs::read_to_string(path.join("reference.jsonl")).expect("reference.jsonl");
        let exceptions = std::fs::read_to_string(path.join("exceptions.json")).unwrap_or_default();
        let files: Vec<_> = step_lines(&reference).map(|(file, facts)| (file.to_owned(), facts.to_owned())).collect();
        assert_eq!(files.len(), count, "STEP files in {}", path.display());
        Some(Corpus { path, files, exceptions })
    };
    FOLDERS.into_iter().filter_map(read).collect()
}

impl Corpus {
    /// All STEP files: name, facts and path.
    pub(crate) fn files(&self) -> impl Iterator<Item = (&str, &str, PathBuf)> {
        self.files.iter().map(|(file, facts)| (&**file, &**facts, self.path.join(file)))
    }

    /// Whether the folder's exceptions state that the reference is wrong about `check` of a file: `faces`, `area` or
    /// `deviation`.
    pub(crate) fn excepts(&self, file: &str, check: &str) -> bool {
        let of_file = self.exceptions.lines().find(|line| line.trim_start().starts_with(&format!("\"{file}\"")));
        let skipped = of_file.and_then(|line| line.split("\"skip\": [").nth(1)?.split(']').next());
        skipped.is_some_and(|checks| checks.contains(&format!("\"{check}\"")))
    }
}

#[test]
fn exceptions_are_those_of_the_folder() {
    let of_a = r#"  "a.stp": {"skip": ["faces", "area"], "why": "[\"deviation\"]"},"#;
    let exceptions = ["{", of_a, r#"  "b.stp": {"skip": []}"#, "}"].join("\n");
    let corpus = Corpus { path: PathBuf::new(), files: Vec::new(), exceptions };
    let known = ["faces", "area", "deviation"].map(|check| corpus.excepts("a.stp", check));
    assert_eq!(known, [true, true, false]);
    assert!(!corpus.excepts("b.stp", "faces") && !corpus.excepts("c.stp", "faces"));
}
