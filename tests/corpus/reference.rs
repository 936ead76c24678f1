//! What the corpus's reference.jsonl says.

use std::path::Path;

/// The value of a key in one line of JSON, up to the next comma or bracket.
pub(crate) fn value<'a>(line: &'a str, key: &str) -> Option<&'a str> {
    let start = line.find(&format!("\"{key}\": "))? + key.len() + 4;
    let rest = &line[start..];
    Some(rest[..rest.find([',', '}']).unwrap_or(rest.len())].trim_matches(['"', '[', ']']))
}

/// File names and their facts: the STEP files of the reference.
pub(crate) fn files(reference: &str) -> impl Iterator<Item = (&str, &str)> {
    reference
        .lines()
        .filter_map(|line| Some((value(line, "file")?, line)))
        .filter(|(file, _)| Path::new(file).extension().is_some_and(|e| e == "stp" || e == "step"))
}
