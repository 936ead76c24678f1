//! The length of the pieces in which the syntax is parsed, and the number of threads, change nothing.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use super::super::text::PIECE;
use super::{FAR, about_its_centre, read, read_file, read_in_pieces};
use crate::control::{Alone, Call, Control, Threads, assert_each_cancels};
use crate::import::step::{StepError, StepOptions};
use crate::model::{Model, Part};
use crate::sequence::random::SplitMix;
use glam::DVec3;
use std::fs;
use std::path::{Path, PathBuf};

/// STEP files of a folder of the checkout, with their texts.
fn texts(folder: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let Ok(entries) = fs::read_dir(&path) else {
        println!("skipped: no files at {}", path.display());
        return Vec::new();
    };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "step" || ending == "stp"));
    paths.sort();
    paths.into_iter().map(|path| (path.clone(), fs::read(path).unwrap())).collect()
}

/// The model with its diagnostics, or the error, as text.
fn outcome(text: &[u8], piece: usize, threads: &Threads) -> String {
    // Few instances, so that mutants with assemblies in assemblies do not take long.
    let options = StepOptions::DEFAULT.with_max_instances(10_000);
    format!("{:?}", read_in_pieces(Call::new(threads, &Control::default()), text.into(), &options, piece))
}

struct Pools([Threads; 2]);

impl Pools {
    fn new() -> Self {
        Self([1, 2].map(|count| Threads::start(count).unwrap()))
    }

    fn assert_same(&self, text: &[u8], name: &str) {
        let [one, two] = &self.0;
        let whole = outcome(text, usize::MAX, one);
        for (piece, pool) in [(1, two), (1000, one), (1000, two), (PIECE, two)] {
            let other = outcome(text, piece, pool);
            if whole != other {
                let at = whole.bytes().zip(other.bytes()).position(|(a, b)| a != b).unwrap_or(0).saturating_sub(80);
                let [whole, other] = [&whole, &other].map(|all| all.chars().skip(at).take(400).collect::<String>());
                panic!("{name}: whole\n{whole}\nin pieces of {piece}\n{other}\n{}", String::from_utf8_lossy(text));
            }
        }
    }
}

const INSERTED: [&[u8]; 24] = [
    b"'",
    b"''",
    b"(",
    b")",
    b";",
    b"=",
    b"#",
    b"<",
    b">",
    b"@",
    b"\\",
    b"/*",
    b"*/",
    b"\"",
    b",,",
    b"ENDSEC;",
    b"\xE9",
    "é".as_bytes(),
    b"#1=",
    b"END-ISO-10303-21;",
    b"/* ; #1=A(' */",
    b"ENDSEC;DATA;",
    b"DATA",
    b"SIGNATURE;",
];

const INSTANCES: [&[u8]; 6] = [
    b"\n#99999999=DESCRIPTIVE_REPRESENTATION_ITEM('a;\n#1=B(2);','<b>;');",
    b"#99999998=A(,,'\\X2\\zz');",
    b"\n#99999997=A('\xE9');#99999997=A('\xC3\xA9');",
    b"\n#99999996=A(((((1)))),?);",
    b"\n#99999995=A(1)",
    b"/* #99999994=A(1); */ #99999993=A(@3,#PI);",
];

/// The text with a few edits: cut short, bytes changed, inserted, deleted, instances repeated or added.
fn mutant(text: &[u8], random: &mut SplitMix) -> Vec<u8> {
    let mut text = text.to_vec();
    let mut below = |count: usize| usize::try_from(random.below(count.max(1) as u64)).unwrap();
    for _ in 0..=below(3) {
        let at = below(text.len());
        let behind = |text: &[u8], at: usize| {
            text[at..].iter().position(|b| *b == b';').map_or(text.len(), |length| at + length + 1)
        };
        match below(12) {
            0 => text.truncate(at),
            1 | 2 => text[at] ^= 1 << below(8),
            3 => {
                let to = (at + below(60)).min(text.len());
                text.drain(at..to);
            }
            4 | 5 => {
                let from = text[..at].iter().rposition(|b| *b == b';').map_or(0, |i| i + 1);
                let instance = text[from..behind(&text, at)].to_vec();
                let to = behind(&text, below(text.len()));
                text.splice(to..to, instance);
            }
            6 | 7 => {
                let to = behind(&text, at);
                text.splice(to..to, INSTANCES[below(INSTANCES.len())].iter().copied());
            }
            8 => text.retain(|b| *b != b'\n'),
            _ => {
                text.splice(at..at, INSERTED[below(INSERTED.len())].iter().copied());
            }
        }
        if text.is_empty() {
            break;
        }
    }
    text
}

#[test]
fn files_read_the_same_in_pieces() {
    let pools = Pools::new();
    for folder in ["tests/data", "tests/fuzz/seeds", "../shared/corpus", "../shared/corpus-closed", "../shared/attack"]
    {
        for (path, text) in texts(folder).iter().filter(|(_, text)| text.len() < 1 << 22) {
            pools.assert_same(text, &path.display().to_string());
        }
    }
}

#[test]
fn mutants_read_the_same_in_pieces() {
    let pools = Pools::new();
    let mut random = SplitMix(1);
    for (folder, count) in [("tests/data", 20), ("tests/fuzz/seeds", 100), ("../shared/corpus", 8)] {
        for (path, text) in texts(folder).iter().filter(|(_, text)| text.len() < 1 << 20) {
            for k in 0..count {
                pools.assert_same(&mutant(text, &mut random), &format!("{}, mutant {k}", path.display()));
            }
        }
    }
}

/// The text with each number times `factor`, and its instances in another order if there is one.
fn renumbered(text: &[u8], factor: u64, order: Option<&mut SplitMix>) -> Vec<u8> {
    let text = String::from_utf8(text.to_vec()).unwrap();
    let (head, data) = text.split_once("DATA;").unwrap();
    let (data, end) = data.rsplit_once("ENDSEC;").unwrap();
    let mut records = vec![String::new()];
    let mut quoted = false;
    let mut characters = data.chars().peekable();
    while let Some(character) = characters.next() {
        let record = records.last_mut().unwrap();
        record.push(character);
        quoted ^= character == '\'';
        if character == '#' && !quoted {
            let number: String = std::iter::from_fn(|| characters.next_if(char::is_ascii_digit)).collect();
            record.push_str(&(factor * number.parse::<u64>().unwrap()).to_string());
        } else if character == ';' && !quoted {
            records.push(String::new());
        }
    }
    let count = records.len() - 1;
    if let Some(random) = order {
        (1..count).for_each(|k| records.swap(k, random.below(k as u64 + 1) as usize));
    }
    format!("{head}DATA;{}ENDSEC;{end}", records.concat()).into_bytes()
}

#[test]
fn instances_are_found_in_any_order_and_by_sparse_numbers() {
    let pools = Pools::new();
    let mut random = SplitMix(2);
    for (path, text) in texts("tests/data").iter().filter(|(_, text)| text.len() < 1 << 20) {
        let [one, _] = &pools.0;
        let (ordered, dense) = (outcome(text, PIECE, one), renumbered(text, 1, Some(&mut random)));
        assert_eq!(outcome(&dense, PIECE, one), ordered, "{}", path.display());
        pools.assert_same(&dense, &path.display().to_string());
        // Diagnostics name instances by their numbers.
        let options = StepOptions::DEFAULT;
        for order in [None, Some(&mut random)] {
            let sparse = renumbered(text, 1 << 20, order);
            pools.assert_same(&sparse, &path.display().to_string());
            let [a, b] = [text, &sparse].map(|text| read(text, &options).unwrap());
            let faces = |model: &Model| model.parts.iter().map(|part| part.faces.len()).collect::<Vec<_>>();
            assert_eq!((faces(&a), a.instances.len()), (faces(&b), b.instances.len()), "{}", path.display());
        }
    }
}

/// Texts that many guesses, or many scans for an end, could read to the end each. Takes no time if none does.
#[test]
fn scans_for_an_end_are_bounded() {
    let pools = Pools::new();
    let text = |data: &str| {
        let head = "ISO-10303-21;HEADER;FILE_DESCRIPTION();FILE_NAME();FILE_SCHEMA(());ENDSEC;";
        format!("{head}{data}ENDSEC;END-ISO-10303-21;").into_bytes()
    };
    for (name, data) in [
        (
            "guesses in comments",
            format!("DATA;#1=A(({}));", format!("/*;#1=A((/**/{}", ",".repeat(1 << 12)).repeat(300)),
        ),
        ("comments without an end", format!("DATA;{}", format!("#1=A(/*{});\n", " ".repeat(1 << 12)).repeat(300))),
        ("escapes without an end", format!("DATA;#1=A('{}');", "\\X2\\ ".repeat(300_000))),
        ("resources without an end", format!("DATA;#1=A({}$);", "<,".repeat(500_000))),
        ("sections without an end", format!("{}DATA;", "ANCHOR/*ENDSEC;".repeat(100_000))),
        ("many types", format!("DATA;#1=({});", "A()".repeat(300_000))),
    ] {
        pools.assert_same(&text(&data), name);
    }
}

#[test]
fn pieces_agree_on_repeated_numbers_and_the_fault_that_is_one_too_many() {
    let pools = Pools::new();
    let head = "ISO-10303-21;HEADER;FILE_DESCRIPTION();FILE_NAME();FILE_SCHEMA(());ENDSEC;DATA;\n";
    let quoted = "#7=A(''',1);\n#8=?;\n#9=A('n',1);\n";
    let bad = "#6=?;\n".repeat(15);
    for data in [
        "#18446744073709551615=A();#18446744073709551615=B();".to_owned(),
        format!("#10=A();#5=B();{bad}{quoted}"),
        format!("{quoted}{bad}#10=A();#10=B();"),
        "#1=?; /* a */ #2=B(); /* b */ #3=!C();".to_owned(),
        "#1=A();END-ISO-10303-21;\n#2=A();".to_owned(),
    ] {
        pools.assert_same(format!("{head}{data}ENDSEC;END-ISO-10303-21;").as_bytes(), &data);
    }
}

#[test]
fn reads_are_cancelled_wherever_they_look() {
    for (path, text) in texts("tests/data").iter().chain(&texts("tests/fuzz/seeds")) {
        for piece in [1000, PIECE] {
            assert_each_cancels(&path.display().to_string(), 200, |control| {
                let read = read_in_pieces(Call::new(&Alone, control), text.into(), &StepOptions::DEFAULT, piece);
                matches!(read, Err(StepError::Cancelled))
            });
        }
    }
}

#[test]
#[cfg(unix)]
fn stretches_of_a_file_are_what_it_holds() {
    use super::in_stretches;
    use std::io::Read as _;
    let path = std::env::temp_dir().join(format!("trimtess-stretches-{}.step", std::process::id()));
    let length: u32 = (1 << 24) + 1000;
    let bytes: Vec<u8> = (0..length + 3).map(|k: u32| (k.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    fs::write(&path, &bytes).unwrap();
    let (pool, control) = (Threads::start(3).unwrap(), Control::default());
    let file = fs::File::open(&path).unwrap();
    let first = in_stretches(Call::new(&pool, &control), &file, length.into()).unwrap().unwrap();
    let (before, after) = bytes.split_at(length as usize);
    assert!(first == before);
    let mut rest = Vec::new();
    (&file).read_to_end(&mut rest).unwrap();
    assert_eq!(rest, after);
    // A file that became shorter, and one that one thread reads as fast.
    for length in [bytes.len() as u64 + 1, 1 << 24] {
        assert_eq!(in_stretches(Call::new(&pool, &control), &file, length).unwrap(), None);
    }
    assert_eq!(in_stretches(Call::new(&Alone, &control), &file, length.into()).unwrap(), None);
    fs::remove_file(path).unwrap();
}

#[test]
fn long_files_are_read_to_the_end() {
    let path = std::env::temp_dir().join(format!("trimtess-long-{}.step", std::process::id()));
    let points: String =
        (0..40_000).map(|k| format!("#{}=CARTESIAN_POINT('',(0.,0.,{k}.));\n", 1_000_000 + k)).collect();
    let cube =
        fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/red_cube_blue_cylinder.step")).unwrap();
    let text = cube.replacen("DATA;", &format!("DATA;\n{points}"), 1);
    fs::write(&path, &text).unwrap();
    let options = StepOptions::DEFAULT;
    let [file, bytes] = [read_file(&path, &options).unwrap(), read(text.as_bytes(), &options).unwrap()];
    assert_eq!((file.parts.len(), &file.parts), (2, &bytes.parts));
    assert_eq!(file.diagnostics, bytes.diagnostics);
    let length = text.len() as u64;
    assert!(read_file(&path, &options.clone().with_max_bytes(length)).is_ok());
    let refused = read_file(&path, &options.clone().with_max_bytes(length - 1));
    assert!(matches!(refused, Err(StepError::TooLarge { .. })), "{refused:?}");
    // Without its end, it is cut.
    fs::write(&path, &text[..text.len() - 20]).unwrap();
    assert_ne!(read_file(&path, &options).unwrap().diagnostics, bytes.diagnostics);
    fs::remove_file(path).unwrap();
}

#[test]
fn parts_are_moved_by_their_whole_box() {
    let moved = |xs: &[f64]| {
        let vertices = xs.iter().map(|&x| DVec3::new(x, 0.0, 0.0)).collect();
        about_its_centre(&mut Part { vertices, ..Part::default() }, &mut Vec::new()).map(|centre| centre.x)
    };
    let far = 1.5 * FAR;
    assert_eq!(moved(&[far, far + 1.0]), Some(far + 0.5));
    assert_eq!(moved(&[far, far + 1.0, far + 0.5, far - 0.2]), Some(far + 0.4));
    // The last point widens the box.
    for xs in [&[far, far + 1.0, 0.0][..], &[far, far + 1.0, far + 2.0], &[0.0, 1.0], &[0.0], &[far], &[]] {
        assert_eq!(moved(xs), None, "{xs:?}");
    }
}
