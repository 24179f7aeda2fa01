//! A crate as modules, one for each file, and the names that each file takes from others.
//!
//! Read as text, without a compiler: paths that begin with `crate`, `self`, `super`, a child module or an imported name are
//! followed through re-exports to the file that defines the name. Code behind `#[cfg(test)]` does not count. Methods and
//! fields are not seen; whoever calls them has the type from somewhere.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use syn::visit::Visit;

use crate::files::{ReadError, read};

/// Re-exports are followed this far; more is a circle of re-exports, which the compiler refuses.
const MOST_HOPS: usize = 16;

/// One file's use of a name that another file defines. Modules are named by their path from the crate's root.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Use {
    /// The module that uses it.
    pub from: Vec<String>,
    /// The module that defines it.
    pub to: Vec<String>,
    /// The name.
    pub name: String,
}

/// What a module's file says, tests left out.
#[derive(Debug, Default)]
struct Module {
    /// Names that `use` brings in, each with the path behind it, as written.
    imports: Vec<Import>,
    /// Paths in code, as written.
    paths: Vec<Vec<String>>,
    /// Child modules with files of their own.
    children: Vec<String>,
}

#[derive(Clone, Debug)]
struct Import {
    /// `None` for everything (`*`).
    name: Option<String>,
    path: Vec<String>,
}

/// A crate's modules.
#[derive(Debug, Default)]
pub struct Crate {
    modules: BTreeMap<Vec<String>, Module>,
}

impl Crate {
    /// Reads the crate whose root is the file `entry`.
    ///
    /// # Errors
    /// [`ReadError`] when a file cannot be read or is no Rust.
    pub fn read(entry: &Path) -> Result<Self, ReadError> {
        let mut all = Self::default();
        let folder = entry.parent().unwrap_or(entry).to_owned();
        all.add(Vec::new(), entry, &folder)?;
        Ok(all)
    }

    /// How deep the deepest module lies.
    #[must_use]
    pub fn depth(&self) -> usize {
        self.modules.keys().map(Vec::len).max().unwrap_or(0)
    }

    /// Every use of one file's names in another, each once.
    #[must_use]
    pub fn uses(&self) -> Vec<Use> {
        let mut uses = Vec::new();
        for (at, module) in &self.modules {
            // A `mod.rs` or `lib.rs` that re-exports only tells where a name is; what its own code says is a use.
            for path in &module.paths {
                uses.extend(self.use_of(at, path));
            }
            let named = |name: &String| module.paths.iter().any(|path| path.first() == Some(name));
            for import in &module.imports {
                let is_reexport =
                    !module.children.is_empty() && !import.name.as_ref().is_some_and(named);
                if !is_reexport {
                    uses.extend(self.use_of(at, &import.path));
                }
            }
        }
        uses.sort();
        uses.dedup();
        uses
    }

    fn use_of(&self, at: &[String], path: &[String]) -> Option<Use> {
        let to = self.definer(at, path, 0)?;
        let name = path.last()?.clone();
        (to != at).then(|| Use {
            from: at.to_vec(),
            to,
            name,
        })
    }

    /// The module that defines what `path` names in the module `at`; `None` when that is another crate's, or a module.
    fn definer(&self, at: &[String], path: &[String], hops: usize) -> Option<Vec<String>> {
        if hops > MOST_HOPS {
            return None;
        }
        let (first, mut rest) = path.split_first()?;
        let mut here: Vec<String> = match first.as_str() {
            "crate" => Vec::new(),
            "self" => at.to_vec(),
            "super" => at.split_last()?.1.to_vec(),
            name => return self.definer_in_scope(at, name, rest, hops),
        };
        while let Some((segment, behind)) = rest.split_first() {
            if segment == "super" {
                here.pop()?;
                rest = behind;
                continue;
            }
            let mut child = here.clone();
            child.push(segment.clone());
            if self.modules.contains_key(&child) {
                here = child;
                rest = behind;
                continue;
            }
            if segment == "*" {
                // A glob over a module: taken as a use of that module.
                return Some(here);
            }
            if let Some(import) = self.import(&here, segment) {
                let path: Vec<String> = import.path.iter().chain(behind).cloned().collect();
                return self.definer(&here, &path, hops + 1);
            }
            return Some(self.through_globs(&here, segment, hops).unwrap_or(here));
        }
        None
    }

    /// A path that begins with a name in scope: a child module, or something imported.
    fn definer_in_scope(
        &self,
        at: &[String],
        name: &str,
        rest: &[String],
        hops: usize,
    ) -> Option<Vec<String>> {
        let mut child = at.to_vec();
        child.push(name.to_owned());
        let behind = |start: Vec<String>| start.into_iter().chain(rest.iter().cloned()).collect();
        if self.modules.contains_key(&child) {
            let path: Vec<String> = behind(vec!["self".to_owned(), name.to_owned()]);
            return self.definer(at, &path, hops + 1);
        }
        let import = self.import(at, name)?;
        // `use serde::Serialize` and the like lead out of the crate.
        let path: Vec<String> = behind(import.path.clone());
        if path.first().is_some_and(|first| first == name) {
            return None;
        }
        self.definer(at, &path, hops + 1)
    }

    fn import(&self, at: &[String], name: &str) -> Option<&Import> {
        let imports = &self.modules.get(at)?.imports;
        imports
            .iter()
            .find(|import| import.name.as_deref() == Some(name))
    }

    /// A name that `pub use child::*` brings in.
    fn through_globs(&self, at: &[String], name: &str, hops: usize) -> Option<Vec<String>> {
        let globs = self.modules.get(at)?.imports.iter();
        globs
            .filter(|import| import.name.is_none())
            .find_map(|import| {
                let (_, module) = import.path.split_last()?;
                let path: Vec<String> = module.iter().cloned().chain([name.to_owned()]).collect();
                self.definer(at, &path, hops + 1)
            })
    }

    fn add(&mut self, at: Vec<String>, file: &Path, folder: &Path) -> Result<(), ReadError> {
        let text = read(file)?;
        let syntax = syn::parse_file(&text).map_err(|error| ReadError::Rust {
            path: file.to_owned(),
            error,
        })?;
        let mut reader = Reader::default();
        reader.visit_file(&syntax);
        let children = reader.children.clone();
        let module = Module {
            imports: reader.imports,
            paths: reader.paths,
            children: reader.children,
        };
        self.modules.insert(at.clone(), module);
        for name in children {
            let (file, inside) = child_file(folder, &name);
            let mut path = at.clone();
            path.push(name);
            self.add(path, &file, &inside)?;
        }
        Ok(())
    }
}

/// The file of a child module, and the folder of its own children.
pub(crate) fn child_file(folder: &Path, name: &str) -> (PathBuf, PathBuf) {
    let inside = folder.join(name);
    let as_folder = inside.join("mod.rs");
    if as_folder.is_file() {
        (as_folder, inside)
    } else {
        (folder.join(format!("{name}.rs")), inside)
    }
}

#[derive(Default)]
struct Reader {
    imports: Vec<Import>,
    paths: Vec<Vec<String>>,
    children: Vec<String>,
}

impl Reader {
    fn import(&mut self, before: &[String], tree: &syn::UseTree) {
        let with = |name: &syn::Ident| {
            let mut path = before.to_vec();
            path.push(name.to_string());
            path
        };
        match tree {
            syn::UseTree::Path(part) => self.import(&with(&part.ident), &part.tree),
            syn::UseTree::Name(part) if part.ident == "self" => {
                self.push(before.last().cloned(), before.to_vec());
            }
            syn::UseTree::Name(part) => {
                self.push(Some(part.ident.to_string()), with(&part.ident));
            }
            syn::UseTree::Rename(part) => {
                let path = if part.ident == "self" {
                    before.to_vec()
                } else {
                    with(&part.ident)
                };
                self.push(Some(part.rename.to_string()), path);
            }
            syn::UseTree::Glob(_) => {
                let mut path = before.to_vec();
                path.push("*".to_owned());
                self.push(None, path);
            }
            syn::UseTree::Group(group) => {
                for item in &group.items {
                    self.import(before, item);
                }
            }
        }
    }

    fn push(&mut self, name: Option<String>, path: Vec<String>) {
        self.imports.push(Import { name, path });
    }
}

/// `#[test]`, or `#[cfg(…)]` that names `test`, `doctest` or `loom`.
fn is_for_tests(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        syn::Meta::Path(path) => path.is_ident("test"),
        syn::Meta::List(list) => {
            let text = list.tokens.to_string();
            list.path.is_ident("cfg")
                && (text == "test" || text == "doctest" || text.contains("test ,"))
        }
        syn::Meta::NameValue(_) => false,
    })
}

impl<'ast> Visit<'ast> for Reader {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        let attributes: &[syn::Attribute] = match item {
            syn::Item::Const(item) => &item.attrs,
            syn::Item::Enum(item) => &item.attrs,
            syn::Item::Fn(item) => &item.attrs,
            syn::Item::Impl(item) => &item.attrs,
            syn::Item::Macro(item) => &item.attrs,
            syn::Item::Mod(item) => &item.attrs,
            syn::Item::Static(item) => &item.attrs,
            syn::Item::Struct(item) => &item.attrs,
            syn::Item::Use(item) => &item.attrs,
            _ => &[],
        };
        if !is_for_tests(attributes) {
            syn::visit::visit_item(self, item);
        }
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if item.content.is_none() {
            self.children.push(item.ident.to_string());
        }
        syn::visit::visit_item_mod(self, item);
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        self.import(&[], &item.tree);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let segments = path.segments.iter();
        self.paths
            .push(segments.map(|segment| segment.ident.to_string()).collect());
        syn::visit::visit_path(self, path);
    }

    fn visit_visibility(&mut self, _: &'ast syn::Visibility) {
        // `pub(super)` uses nothing.
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn uses(files: &[(&str, &str)]) -> Vec<String> {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, text) in files {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
            fs::write(path, text).expect("written");
        }
        let krate = Crate::read(&folder.path().join("lib.rs")).expect("a crate");
        let uses = krate.uses().into_iter();
        uses.map(|one| {
            format!(
                "{} > {}: {}",
                one.from.join("::"),
                one.to.join("::"),
                one.name
            )
        })
        .collect()
    }

    #[test]
    fn a_name_is_followed_through_re_exports_to_its_file() {
        let found = uses(&[
            ("lib.rs", "mod a; mod b; pub use b::Deep;"),
            ("a.rs", "use crate::b::Deep; fn f(_: Deep) {}"),
            ("b/mod.rs", "mod c; pub use c::Deep;"),
            ("b/c.rs", "pub struct Deep;"),
        ]);
        assert_eq!(found, ["a > b::c: Deep"]);
    }

    #[test]
    fn paths_in_code_and_imported_modules_count() {
        let found = uses(&[
            ("lib.rs", "mod a; mod b;"),
            (
                "a.rs",
                "use crate::b; use super::b as other; fn f() { b::g(); other::h(); crate::b::i() }",
            ),
            ("b.rs", "pub fn g() {} pub fn h() {} pub fn i() {}"),
        ]);
        assert_eq!(found, ["a > b: g", "a > b: h", "a > b: i"]);
    }

    #[test]
    fn what_a_parent_defines_is_a_use_of_the_parent() {
        let found = uses(&[
            ("lib.rs", "mod a;"),
            ("a/mod.rs", "mod b; pub struct Mine; fn f() { b::g() }"),
            ("a/b.rs", "use super::Mine; pub fn g() -> Mine { Mine }"),
        ]);
        assert_eq!(found, ["a > a::b: g", "a::b > a: Mine"]);
    }

    #[test]
    fn tests_and_other_crates_do_not_count() {
        let found = uses(&[
            ("lib.rs", "mod a; mod b;"),
            (
                "a.rs",
                "use std::fmt::Debug; #[cfg(test)] mod tests { use crate::b::B; }",
            ),
            ("b.rs", "pub struct B;"),
        ]);
        assert_eq!(found, [""; 0]);
    }
}
