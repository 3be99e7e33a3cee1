//! The layers of the crate: no module imports one of a higher layer, and no two import each other, directly or in a
//! circle.
//!
//! A module is a file. Imports are followed through re-exports to the file that defines the item; unit tests are
//! ignored.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

use syn::{
    Attribute, Item, UseTree, Visibility,
    visit::{self, Visit},
};

/// Top-level modules from bottom to top: each may import the ones before it.
const FLOORS: &[&str] = &[
    "simd",
    "memory",
    "input",
    "communicator",
    "measure",
    "mesh",
    "scene",
    "kernel",
    "lattice",
    "state",
    "index",
    "sampling",
    "filling",
    "neighbours",
    "pairs",
    "boundary",
    "density",
    "integrate",
    "reorder",
    "flow",
    "time_step",
    "pressure",
    "force",
    "gauge",
    "registry",
    "loading",
    "ranks",
    "step",
    "plugin",
    "output",
    "checkpoint",
    "study",
    "validate",
    "guide",
    "frontier",
    "trial",
];

/// A path inside the crate, segment by segment.
type ModPath = Vec<String>;

#[derive(Default)]
struct Module {
    /// Names that it defines.
    defines: BTreeSet<String>,
    /// Names that it re-exports, with their paths; `*` for all names of a module.
    exports: Vec<(String, ModPath)>,
    /// Paths that it uses.
    uses: Vec<ModPath>,
}

fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("cfg")
            && attribute
                .parse_args::<syn::Path>()
                .is_ok_and(|path| path.is_ident("test"))
    })
}

/// Leaves of a `use`, each with the name that it gives to a path.
fn leaves(tree: &UseTree, before: &mut ModPath, put: &mut impl FnMut(String, ModPath)) {
    match tree {
        UseTree::Path(path) => {
            before.push(path.ident.to_string());
            leaves(&path.tree, before, put);
            before.pop();
        }
        UseTree::Name(name) if name.ident == "self" => {
            put(before.last().cloned().unwrap_or_default(), before.clone());
        }
        UseTree::Name(name) => {
            let mut path = before.clone();
            path.push(name.ident.to_string());
            put(name.ident.to_string(), path);
        }
        UseTree::Rename(rename) => {
            let mut path = before.clone();
            if rename.ident != "self" {
                path.push(rename.ident.to_string());
            }
            put(rename.rename.to_string(), path);
        }
        UseTree::Glob(_) => put("*".to_owned(), before.clone()),
        UseTree::Group(group) => {
            for tree in &group.items {
                leaves(tree, before, put);
            }
        }
    }
}

/// Reads one file.
struct Reader {
    module: ModPath,
    children: BTreeSet<String>,
    /// Names that imports give to paths inside the crate.
    names: BTreeMap<String, ModPath>,
    found: Module,
}

impl Reader {
    /// A path as written in the file, from the root of the crate; `None` if it leads outside the crate.
    fn absolute(&self, path: &[String]) -> Option<ModPath> {
        let (first, rest) = path.split_first()?;
        let mut from = match first.as_str() {
            "crate" => Vec::new(),
            "self" => self.module.clone(),
            "super" => self.module[..self.module.len().checked_sub(1)?].to_vec(),
            name if self.children.contains(name) => [&self.module[..], &[name.to_owned()]].concat(),
            name => self.names.get(name)?.clone(),
        };
        for segment in rest {
            if segment == "super" {
                from.pop();
            } else {
                from.push(segment.clone());
            }
        }
        Some(from)
    }

    fn import(&mut self, item: &syn::ItemUse) {
        let mut found = Vec::new();
        leaves(&item.tree, &mut Vec::new(), &mut |name, path| {
            found.push((name, path));
        });
        for (name, path) in found {
            let Some(path) = self.absolute(&path) else {
                continue;
            };
            let is_private = matches!(item.vis, Visibility::Inherited);
            let is_below = path.starts_with(&self.module) && path.len() > self.module.len() + 1;
            if !is_private {
                self.found.exports.push((name.clone(), path.clone()));
            }
            if is_private || !is_below {
                self.found.uses.push(path.clone());
            }
            self.names.insert(name, path);
        }
    }
}

impl<'ast> Visit<'ast> for Reader {
    fn visit_item(&mut self, item: &'ast Item) {
        let attributes: &[Attribute] = match item {
            Item::Mod(item) => &item.attrs,
            Item::Fn(item) => &item.attrs,
            Item::Impl(item) => &item.attrs,
            Item::Use(item) => &item.attrs,
            _ => &[],
        };
        if is_test(attributes) || matches!(item, Item::Use(_)) {
            return;
        }
        visit::visit_item(self, item);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let segments: ModPath = path.segments.iter().map(|s| s.ident.to_string()).collect();
        if segments.len() > 1
            && let Some(path) = self.absolute(&segments)
        {
            self.found.uses.push(path);
        }
        visit::visit_path(self, path);
    }
}

fn defined(item: &Item) -> Option<String> {
    Some(match item {
        Item::Const(item) => item.ident.to_string(),
        Item::Enum(item) => item.ident.to_string(),
        Item::Fn(item) => item.sig.ident.to_string(),
        Item::Static(item) => item.ident.to_string(),
        Item::Struct(item) => item.ident.to_string(),
        Item::Trait(item) => item.ident.to_string(),
        Item::Type(item) => item.ident.to_string(),
        _ => return None,
    })
}

/// Reads the file of a module and those of its children.
fn read(file: &Path, folder: &Path, module: ModPath, modules: &mut BTreeMap<ModPath, Module>) {
    let text = fs::read_to_string(file).expect("a source file");
    let parsed =
        syn::parse_file(&text).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let children: BTreeSet<String> = (parsed.items.iter())
        .filter_map(|item| match item {
            Item::Mod(item) if item.content.is_none() && !is_test(&item.attrs) => {
                Some(item.ident.to_string())
            }
            _ => None,
        })
        .collect();
    let mut reader = Reader {
        module: module.clone(),
        children: children.clone(),
        names: BTreeMap::new(),
        found: Module::default(),
    };
    // Twice, because an import may use a name that a later one introduces.
    for _ in 0..2 {
        reader.found = Module::default();
        for item in &parsed.items {
            if let Item::Use(item) = item
                && !is_test(&item.attrs)
            {
                reader.import(item);
            }
        }
    }
    reader.found.defines = parsed.items.iter().filter_map(defined).collect();
    reader.visit_file(&parsed);
    modules.insert(module.clone(), reader.found);
    for child in children {
        let own = folder.join(format!("{child}.rs"));
        let path = [&module[..], std::slice::from_ref(&child)].concat();
        if own.is_file() {
            read(&own, &folder.join(&child), path, modules);
        } else {
            let inner = folder.join(&child);
            read(&inner.join("mod.rs"), &inner, path, modules);
        }
    }
}

/// The module whose file defines the item of a path.
fn definition(path: &[String], modules: &BTreeMap<ModPath, Module>, depth: u32) -> Option<ModPath> {
    let mut at: ModPath = Vec::new();
    let mut rest = path;
    while let Some((first, others)) = rest.split_first() {
        let child = [&at[..], std::slice::from_ref(first)].concat();
        if modules.contains_key(&child) {
            (at, rest) = (child, others);
            continue;
        }
        let module = modules.get(&at)?;
        if module.defines.contains(first) || depth == 0 {
            return Some(at);
        }
        let through = |target: &ModPath| {
            let path = [&target[..], others].concat();
            definition(&path, modules, depth - 1)
        };
        for (name, target) in &module.exports {
            if name == first {
                return through(target);
            }
        }
        for (_, target) in module.exports.iter().filter(|(name, _)| name == "*") {
            if modules
                .get(target)
                .is_some_and(|of| of.defines.contains(first))
            {
                return Some(target.clone());
            }
        }
        return Some(at);
    }
    // An imported module as a whole: longer paths that begin with it show what is used.
    None
}

fn imports(root: &str) -> BTreeMap<ModPath, BTreeSet<ModPath>> {
    let source = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut modules = BTreeMap::new();
    read(&source.join(root), &source, Vec::new(), &mut modules);
    let of = |(module, found): (&ModPath, &Module)| {
        let uses = found.uses.iter();
        let to = uses.filter_map(|path| definition(path, &modules, 8));
        (module.clone(), to.filter(|to| to != module).collect())
    };
    modules.iter().map(of).collect()
}

fn name(module: &[String]) -> String {
    if module.is_empty() {
        "the root".to_owned()
    } else {
        module.join("::")
    }
}

/// A shortest circle through a module, if there is one.
fn circle(from: &ModPath, imports: &BTreeMap<ModPath, BTreeSet<ModPath>>) -> Option<Vec<ModPath>> {
    let mut before: BTreeMap<&ModPath, &ModPath> = BTreeMap::new();
    let mut queue = std::collections::VecDeque::from([from]);
    while let Some(at) = queue.pop_front() {
        for next in imports.get(at).into_iter().flatten() {
            if next == from {
                let mut circle = vec![from.clone()];
                let mut back = at;
                while back != from {
                    circle.insert(1, back.clone());
                    back = before[back];
                }
                return Some(circle);
            }
            if !before.contains_key(next) {
                before.insert(next, at);
                queue.push_back(next);
            }
        }
    }
    None
}

#[test]
fn no_modules_import_each_other_in_a_circle() {
    for root in ["lib.rs", "main.rs"] {
        let imports = imports(root);
        let circles: BTreeSet<String> = (imports.keys())
            .filter_map(|module| circle(module, &imports))
            .map(|mut circle| {
                let least = circle.iter().min().cloned().unwrap_or_default();
                let at = circle
                    .iter()
                    .position(|module| *module == least)
                    .unwrap_or(0);
                circle.rotate_left(at);
                circle.push(least);
                circle
                    .iter()
                    .map(|module| name(module))
                    .collect::<Vec<_>>()
                    .join(" -> ")
            })
            .collect();
        assert!(circles.is_empty(), "{root}: {circles:#?}");
    }
}

#[test]
fn every_module_imports_floors_below_it_alone() {
    let imports = imports("lib.rs");
    let floor = |module: &str| {
        let at = FLOORS.iter().position(|floor| *floor == module);
        at.unwrap_or_else(|| panic!("`{module}` has no floor: add it to the list"))
    };
    let mut wrong = BTreeSet::new();
    for (module, uses) in imports.iter().filter(|(module, _)| !module.is_empty()) {
        for used in uses.iter().filter(|used| !used.is_empty()) {
            if floor(&used[0]) > floor(&module[0]) {
                wrong.insert(format!(
                    "{} imports {}, which is above it",
                    name(module),
                    name(used)
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    let known = imports.keys().filter_map(|module| module.first());
    let known: BTreeSet<&str> = known.map(String::as_str).collect();
    let gone: Vec<_> = FLOORS
        .iter()
        .filter(|floor| !known.contains(*floor))
        .collect();
    assert!(gone.is_empty(), "floors without a module: {gone:?}");
}
