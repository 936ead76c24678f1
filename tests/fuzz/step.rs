//! Bytes -> the text of a STEP file, either verbatim or as edits of a sound one -> a mesh with diagnostics, or one
//! clear error.

use crate::judge::Meshed;
use crate::sequence::judge;
use crate::watch::{self, Case};
use arbitrary::{Result, Unstructured};
use scramble::Scrambled;
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;
use trimtess::import::step::{StepOptions, read};

#[path = "scramble.rs"]
mod scramble;

/// Bytes with this prefix are used verbatim.
const MAGIC: &[u8] = b"ISO-10303-21";
/// Sound texts to edit.
const SEEDS: [&str; 5] = [
    include_str!("seeds/kinds.step"),
    include_str!("seeds/curves.step"),
    include_str!("seeds/assembly.step"),
    include_str!("seeds/forms.step"),
    include_str!("../data/red_cube_blue_cylinder.step"),
];

/// The text of a file.
struct Text(Vec<u8>);

impl Case for Text {
    fn draw(u: &mut Unstructured<'_>) -> Result<Self> {
        if u.peek_bytes(MAGIC.len()) == Some(MAGIC) {
            return Ok(Self(u.bytes(u.len())?.to_vec()));
        }
        let seed = *u.choose(&SEEDS)?;
        Ok(Self(Scrambled::draw(u)?.of(seed).into_bytes()))
    }

    fn judge(&self) -> std::result::Result<(), String> {
        let options = StepOptions::default().with_max_instances(1000).with_max_syntax_repairs(8);
        let Ok(model) = read(&self.0, &options) else { return Ok(()) };
        let meshed = Meshed::new(model, 1e-2)?;
        meshed.holds()?;
        if meshed.report.triangles == 0 && meshed.prepared.diagnostics.is_empty() && meshed.report.degraded.is_empty() {
            return Err("neither triangles nor a diagnostic".to_owned());
        }
        Ok(())
    }

    fn as_test(&self) -> String {
        let mut hash = DefaultHasher::new();
        self.0.hash(&mut hash);
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("found_{:016x}.step", hash.finish()));
        let written = fs::write(&path, &self.0);
        let outcome = written.map_or_else(|error| format!("cannot be written: {error}"), |()| "written".to_owned());
        let text = String::from_utf8_lossy(&self.0);
        format!(
            "{} ({outcome})\nTo commit it: cp it to tests/fuzz/found/NAME.step; `step_found` judges every file \
             there.\n{text}",
            path.display()
        )
    }
}

#[test]
fn step_bytes() {
    judge!(100, 256, |bytes: &[u8]| watch::drawn::<Text>(bytes));
}

/// Files that failed once, shrunk; and the seeds.
#[test]
fn step_found() {
    for folder in ["found", "seeds"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz").join(folder);
        // Git keeps no empty folders.
        for file in fs::read_dir(&folder).into_iter().flatten() {
            let path = file.expect("a file").path();
            println!("{}", path.display());
            watch::sound(&Text(fs::read(&path).expect("a readable file")));
        }
    }
}

/// The seeds are sound, so that edits start from a text that is read and meshed.
#[test]
fn step_seeds() {
    for (number, seed) in SEEDS.iter().enumerate() {
        let model = read(seed.as_bytes(), &StepOptions::default()).expect("a readable seed");
        let meshed = Meshed::new(model, 1e-2).expect("a mesh");
        let told = &meshed.prepared.diagnostics;
        assert!(told.iter().all(|d| d.severity <= trimtess::model::Severity::Note), "seed {number}: {told:?}");
        assert!(meshed.report.degraded.is_empty() && meshed.report.triangles > 0, "seed {number}");
        meshed.holds().and_then(|()| meshed.keeps_tolerance()).unwrap_or_else(|fault| panic!("seed {number}: {fault}"));
    }
}
