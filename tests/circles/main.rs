//! Sources -> cycles between files, and names that break the folder order of docs/architecture.md.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod imports;

use imports::{Module, imports};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

fn src() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// Modules that reach themselves, each with the others on its cycles: strongly connected components (Tarjan 1972) by
/// transitive closure, since the crate is small.
fn circles(of: &BTreeMap<Module, BTreeSet<Module>>) -> Vec<String> {
    let mut reach = of.clone();
    let all: Vec<&Module> = of.keys().collect();
    for middle in &all {
        let beyond = reach[*middle].clone();
        for from in &all {
            if reach[*from].contains(*middle) {
                reach.get_mut(*from).unwrap().extend(beyond.iter().cloned());
            }
        }
    }
    let on_circle =
        |from: &Module, to: &Module| reach[from].contains(to) && reach.get(to).is_some_and(|r| r.contains(from));
    let describe = |from: &Module| {
        let next: Vec<String> = of[from].iter().filter(|to| on_circle(from, to)).map(|to| to.join("/")).collect();
        (!next.is_empty()).then(|| format!("{} -> {}", from.join("/"), next.join(", ")))
    };
    all.into_iter().filter_map(describe).collect()
}

#[test]
fn no_file_takes_part_in_a_cycle() {
    let found = circles(&imports(&src()));
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn modules_name_only_those_that_their_folder_lists_before_them() {
    let all = imports(&src());
    let mut bad = Vec::new();
    for folder in all.keys().filter(|module| !listed(module).is_empty()) {
        let order = listed(folder);
        let place = |of: &Module| {
            let child = of.strip_prefix(folder.as_slice())?.first()?;
            order.iter().position(|name| name == child)
        };
        for (from, named) in &all {
            let Some(here) = place(from) else { continue };
            let above = |to: &Module| to == folder && !folder.is_empty();
            let later = named.iter().filter(|to| above(to) || place(to).is_some_and(|there| there > here));
            bad.extend(later.map(|to| format!("{} names {}", from.join("/"), to.join("/"))));
        }
    }
    assert!(bad.is_empty(), "{bad:#?}");
}

#[test]
fn what_makes_a_mesh_for_a_tolerance_names_no_camera_in_motion() {
    let is_live = |of: &Module| of.starts_with(&["frame", "live"].map(str::to_owned));
    let all = imports(&src());
    let of_static = |from: &&Module| from.len() > 1 && from[0] == "frame" && !is_live(from);
    for from in all.keys().filter(of_static) {
        assert!(!all[from].iter().any(is_live), "{} names live", from.join("/"));
    }
}

#[test]
fn a_cycle_would_be_found() {
    let of = |names: &[(&str, &str)]| -> BTreeMap<Module, BTreeSet<Module>> {
        let mut all: BTreeMap<Module, BTreeSet<Module>> = BTreeMap::new();
        for (from, to) in names {
            all.entry(vec![(*from).to_owned()]).or_default().insert(vec![(*to).to_owned()]);
            all.entry(vec![(*to).to_owned()]).or_default();
        }
        all
    };
    assert!(circles(&of(&[("a", "b"), ("b", "c"), ("a", "c")])).is_empty());
    assert_eq!(circles(&of(&[("a", "b"), ("b", "c"), ("c", "a"), ("d", "a")])).len(), 3);
    // A file known to name others is found to do so.
    let lattice: Module = ["frame", "plan", "lattice"].map(str::to_owned).to_vec();
    let density: Module = ["frame", "plan", "density"].map(str::to_owned).to_vec();
    assert!(imports(&src())[&lattice].contains(&density));
}

/// The modules of a folder, in the order in which its `mod.rs` lists them; none for a file.
fn listed(folder: &Module) -> Vec<String> {
    let dir = folder.iter().fold(src(), |dir, name| dir.join(name));
    let root = if folder.is_empty() { dir.join("lib.rs") } else { dir.join("mod.rs") };
    let Ok(text) = fs::read_to_string(root) else { return Vec::new() };
    let items = syn::parse_file(&text).unwrap().items;
    let modules = items.iter().filter_map(|item| if let syn::Item::Mod(item) = item { Some(item) } else { None });
    modules.filter(|module| module.content.is_none()).map(|module| module.ident.to_string()).collect()
}
