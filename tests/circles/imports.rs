//! The files of `src/` -> which names which: `use` declarations and paths, followed through re-exports to the file that
//! defines the item.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use syn::visit::{self, Visit};
use syn::{Attribute, File, Item, ItemMod, ItemUse, UseTree, Visibility};

/// A module's path below the crate: `["frame", "plan", "lattice"]`.
pub(crate) type Module = Vec<String>;

/// One file: what it names, and what it re-exports under which name.
#[derive(Default)]
struct Names {
    paths: Vec<Vec<String>>,
    reexports: BTreeMap<String, Vec<String>>,
    own: BTreeSet<String>,
}

/// All files of a crate, by module, with the modules that declare what each uses.
pub(crate) fn imports(src: &Path) -> BTreeMap<Module, BTreeSet<Module>> {
    let mut files = BTreeMap::new();
    read(src, &mut Vec::new(), &mut files);
    let resolved = |module: &Module, names: &Names| {
        let named = names.paths.iter().filter_map(|path| resolve(&files, absolute(&files, module, path)?, 0));
        named.filter(|named| named != module).collect()
    };
    files.iter().map(|(module, names)| (module.clone(), resolved(module, names))).collect()
}

fn read(dir: &Path, module: &mut Module, files: &mut BTreeMap<Module, Names>) {
    for entry in fs::read_dir(dir).unwrap() {
        let path = entry.unwrap().path();
        let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            module.push(stem);
            read(&path, module, files);
            module.pop();
        } else if path.extension().is_some_and(|e| e == "rs") {
            let is_root = stem == "mod" || stem == "lib";
            let name = module.iter().cloned().chain((!is_root).then_some(stem)).collect();
            let file = syn::parse_file(&fs::read_to_string(&path).unwrap()).unwrap();
            files.insert(name, Names::of(&file));
        }
    }
}

/// A path as written in `module`, resolved from the crate's root. `None` if it leaves the crate or names an item of its
/// own file.
fn absolute(files: &BTreeMap<Module, Names>, module: &Module, path: &[String]) -> Option<Vec<String>> {
    let supers = path.iter().take_while(|name| *name == "super").count();
    let (base, rest) = match path.first()?.as_str() {
        "crate" => (&module[..0], &path[1..]),
        "self" => (&module[..], &path[1..]),
        "super" => (&module[..module.len().checked_sub(supers)?], &path[supers..]),
        _ => (&module[..], path),
    };
    let absolute = [base, rest].concat();
    let is_stated = path[0] == "crate" || path[0] == "self" || supers > 0;
    (is_stated || files.contains_key(&absolute[..=module.len()])).then_some(absolute)
}

/// The file that defines what a path leads to.
fn resolve(files: &BTreeMap<Module, Names>, path: Vec<String>, depth: usize) -> Option<Module> {
    let known = (0..=path.len()).rev().find(|&k| files.contains_key(&path[..k]))?;
    let names = &files[&path[..known]];
    let Some(next) = path.get(known).filter(|name| !names.own.contains(*name)) else {
        return Some(path[..known].to_vec());
    };
    match names.reexports.get(next).filter(|_| depth < 8) {
        Some(to) => {
            let to = absolute(files, &path[..known].to_vec(), to)?;
            resolve(files, [&to[..], &path[known + 1..]].concat(), depth + 1)
        }
        None => Some(path[..known].to_vec()),
    }
}

impl Names {
    fn of(file: &File) -> Self {
        let mut names = Self::default();
        for item in &file.items {
            let ident = match item {
                Item::Fn(item) => &item.sig.ident,
                Item::Struct(item) => &item.ident,
                Item::Enum(item) => &item.ident,
                Item::Trait(item) => &item.ident,
                Item::Const(item) => &item.ident,
                Item::Type(item) => &item.ident,
                _ => continue,
            };
            names.own.insert(ident.to_string());
        }
        names.visit_file(file);
        names
    }

    fn add_tree(&mut self, tree: &UseTree, before: &mut Vec<String>, is_public: bool) {
        match tree {
            UseTree::Path(path) => {
                before.push(path.ident.to_string());
                self.add_tree(&path.tree, before, is_public);
                before.pop();
            }
            UseTree::Group(group) => group.items.iter().for_each(|tree| self.add_tree(tree, before, is_public)),
            UseTree::Name(name) => self.add(&name.ident.to_string(), &name.ident.to_string(), before, is_public),
            UseTree::Rename(name) => self.add(&name.ident.to_string(), &name.rename.to_string(), before, is_public),
            UseTree::Glob(_) => {}
        }
    }

    fn add(&mut self, name: &str, known_as: &str, before: &[String], is_public: bool) {
        let path: Vec<String> = before.iter().cloned().chain((name != "self").then(|| name.to_owned())).collect();
        if is_public {
            self.reexports.insert(known_as.to_owned(), path);
        } else {
            self.paths.push(path);
        }
    }
}

fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|a| a.path().is_ident("cfg") && a.parse_args::<syn::Ident>().is_ok_and(|i| i == "test"))
}

impl<'ast> Visit<'ast> for Names {
    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        let is_public = !matches!(item.vis, Visibility::Inherited);
        self.add_tree(&item.tree, &mut Vec::new(), is_public);
    }

    fn visit_item_mod(&mut self, item: &'ast ItemMod) {
        // Tests may name anything.
        if !is_test(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_visibility(&mut self, _: &'ast Visibility) {}

    fn visit_path(&mut self, path: &'ast syn::Path) {
        if path.leading_colon.is_none() && path.segments.len() > 1 {
            self.paths.push(path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        }
        visit::visit_path(self, path);
    }
}
