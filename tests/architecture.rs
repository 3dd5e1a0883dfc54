//! Holds the layout to its arrows: which crates may stand on which, and no circle between the files of a crate.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

/// The crates that each crate of ours may stand on; cargo itself refuses circles.
const ARROWS: [(&str, &[&str]); 10] = [
    ("core", &[]),
    ("document", &[]),
    ("render", &[]),
    ("web", &[]),
    ("markers", &["core", "document"]),
    ("pipeline", &["core", "document", "markers", "render"]),
    ("studio", &["core", "document", "markers", "pipeline", "web"]),
    ("plugins", &["core"]),
    ("mimesh", &["core", "document", "markers", "pipeline", "render", "studio", "web", "plugins"]),
    ("python", &["core", "document", "markers", "pipeline", "render", "mimesh"]),
];

/// Crates of others that belong to a command line, which only the program may use.
const COMMAND_LINE: [&str; 6] = ["open", "clap", "clap_complete", "ctrlc", "indicatif", "terminal_size"];

/// Subcommands of the program; `mimesh cache` is also how a cached result begins.
const SUBCOMMANDS: [&str; 17] = [
    "check",
    "compare",
    "inspect",
    "keypoints",
    "list",
    "markers",
    "merge",
    "new",
    "plan",
    "prepare",
    "render",
    "run",
    "schema",
    "score",
    "show",
    "submit",
    "studio",
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The folders of our crates, with the name of their group in [`ARROWS`].
fn crates() -> Vec<(String, PathBuf)> {
    let mut all = vec![("mimesh".to_owned(), root().to_owned()), ("python".to_owned(), root().join("python"))];
    for folder in ["crates", "plugins"] {
        for entry in fs::read_dir(root().join(folder)).expect("a folder of the layout") {
            let path = entry.expect("a readable folder").path();
            if path.join("Cargo.toml").is_file() {
                let name = path.file_name().expect("a name").to_string_lossy().into_owned();
                all.push((if folder == "plugins" { folder.to_owned() } else { name }, path));
            }
        }
    }
    all.sort();
    all
}

/// The dependencies of a crate, without those of tests.
fn dependencies(folder: &Path) -> Vec<String> {
    let text = fs::read_to_string(folder.join("Cargo.toml")).expect("a manifest");
    let table = text.split("\n[dependencies]\n").nth(1).unwrap_or_default();
    let lines = table.lines().take_while(|line| !line.starts_with('['));
    let names = lines.filter_map(|line| line.split(['=', '.', ' ']).next()).filter(|name| !name.is_empty());
    names.map(str::to_owned).collect()
}

#[test]
fn crates_stand_only_on_those_below_them() {
    let plugins: BTreeSet<String> = crates()
        .iter()
        .filter(|(group, _)| group == "plugins")
        .map(|(_, folder)| folder.file_name().expect("a name").to_string_lossy().replace('_', "-"))
        .collect();
    for (group, folder) in crates() {
        let (_, allowed) =
            ARROWS.iter().find(|(name, _)| *name == group).unwrap_or_else(|| panic!("no arrows for {group}"));
        for dependency in dependencies(&folder) {
            assert!(
                group == "mimesh" || !COMMAND_LINE.contains(&dependency.as_str()),
                "{} uses {dependency}, which belongs to the program",
                folder.display()
            );
            let ours = if dependency == "mimesh" { Some("mimesh") } else { dependency.strip_prefix("mimesh-") };
            let Some(ours) = ours else { continue };
            let below = if plugins.contains(ours) { "plugins" } else { ours };
            assert!(allowed.contains(&below), "{} must not stand on mimesh-{ours}", folder.display());
        }
    }
}

/// The files of Rust in `folder` and below.
fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let files = entries.flat_map(|path| if path.is_dir() { rust_files(&path) } else { vec![path] });
    files.filter(|path| path.extension().is_some_and(|extension| extension == "rs")).collect()
}

/// The subcommand of the program that a line of code names; comments may name any.
fn named_subcommand(line: &str) -> Option<&'static str> {
    let code = if line.trim_start().starts_with("//") { "" } else { line };
    code.split("mimesh ").skip(1).find_map(|rest| {
        let word = rest.split(|c: char| !c.is_ascii_alphanumeric()).next().unwrap_or_default();
        SUBCOMMANDS.into_iter().find(|subcommand| *subcommand == word)
    })
}

#[test]
fn libraries_name_no_command_of_the_program() {
    assert_eq!(named_subcommand("\"see `mimesh show transfer`\""), Some("show"));
    for file in rust_files(&root().join("crates")) {
        for (text, line) in fs::read_to_string(&file).expect("a text").lines().zip(1..) {
            // A remedy lets the program name its own commands.
            assert_eq!(named_subcommand(text), None, "{}:{line}: {text}", file.display());
        }
    }
}

#[test]
fn no_files_of_a_crate_import_each_other_in_a_circle() {
    for (_, folder) in crates() {
        let source = Source::read(&folder.join("src"));
        if let Some(circle) = source.circle() {
            panic!("{}: files import each other in a circle: {}", folder.display(), circle.join(" -> "));
        }
    }
}

/// The modules of a crate that define something, and the modules that each imports from.
///
/// A module is known by its path, as `check::runs`. A face (`lib.rs` or `mod.rs` that only declares modules and re-exports) is no
/// module of its own: an import through it is one of the module that defines the name.
struct Source {
    imports: BTreeMap<String, BTreeSet<String>>,
}

impl Source {
    fn read(folder: &Path) -> Self {
        let mut texts = BTreeMap::new();
        collect(folder, "", &mut texts);
        let exports = exports(&texts);
        let mut imports = BTreeMap::new();
        for (module, text) in &texts {
            if is_face(text) {
                continue;
            }
            let mut to = BTreeSet::new();
            for path in used_paths(module, text) {
                if let Some(target) = defining_module(&path, &texts, &exports).filter(|target| target != module) {
                    to.insert(target);
                }
            }
            imports.insert(module.clone(), to);
        }
        Self { imports }
    }

    /// A circle, as the modules on it from the first to the first again.
    fn circle(&self) -> Option<Vec<String>> {
        let mut done = BTreeSet::new();
        self.imports.keys().find_map(|start| self.walk(start, &mut vec![], &mut done))
    }

    fn walk(&self, module: &str, path: &mut Vec<String>, done: &mut BTreeSet<String>) -> Option<Vec<String>> {
        if let Some(at) = path.iter().position(|seen| seen == module) {
            return Some(path[at..].iter().cloned().chain([module.to_owned()]).collect());
        }
        if done.contains(module) {
            return None;
        }
        path.push(module.to_owned());
        for next in self.imports.get(module).into_iter().flatten() {
            if let Some(circle) = self.walk(next, path, done) {
                return Some(circle);
            }
        }
        path.pop();
        done.insert(module.to_owned());
        None
    }
}

/// The texts of all modules below `folder` without their tests and comments, by path.
fn collect(folder: &Path, prefix: &str, texts: &mut BTreeMap<String, String>) {
    for entry in fs::read_dir(folder).expect("a readable folder") {
        let path = entry.expect("a readable entry").path();
        let stem = path.file_stem().expect("a name").to_string_lossy().into_owned();
        let inner = if prefix.is_empty() { stem.clone() } else { format!("{prefix}::{stem}") };
        if path.is_dir() {
            collect(&path, &inner, texts);
        } else if path.extension().is_some_and(|extension| extension == "rs") && stem != "tests" {
            let module = if ["mod", "lib", "main"].contains(&stem.as_str()) { prefix.to_owned() } else { inner };
            let text = fs::read_to_string(&path).expect("UTF-8 text");
            texts.entry(module).or_default().push_str(&production(&text));
        }
    }
}

/// `text` without line comments and without what follows `#[cfg(test)]` at its end.
fn production(text: &str) -> String {
    let code = text.split("\n#[cfg(test)]\nmod tests").next().unwrap_or_default();
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}

/// Whether a module only declares modules and re-exports.
fn is_face(text: &str) -> bool {
    let statements = text.split(';').map(str::trim).filter(|statement| !statement.is_empty());
    statements.into_iter().all(|statement| {
        let statement = statement.trim_start_matches('\n');
        let statement = statement.rsplit("]\n").next().unwrap_or(statement);
        ["mod ", "pub mod ", "pub(crate) mod ", "pub use ", "pub(crate) use ", "use "]
            .iter()
            .any(|start| statement.starts_with(start))
    })
}

/// The names that modules re-export, with the full paths that they stand for: `(module, name) -> path`.
fn exports(texts: &BTreeMap<String, String>) -> BTreeMap<(String, String), String> {
    let mut exports = BTreeMap::new();
    for (module, text) in texts {
        for statement in statements(text, &["pub use ", "pub(crate) use ", "pub(super) use "]) {
            for path in expand(&statement) {
                let (full, name) = match path.split_once(" as ") {
                    Some((full, name)) => (full.to_owned(), name.to_owned()),
                    None => (path.clone(), path.rsplit("::").next().unwrap_or_default().to_owned()),
                };
                exports.insert((module.clone(), name), absolute(module, &full, texts));
            }
        }
    }
    exports
}

/// The full paths within the crate that a module uses, in `use` statements and in expressions.
fn used_paths(module: &str, text: &str) -> Vec<String> {
    let mut paths: Vec<String> = Vec::new();
    for statement in statements(text, &["use ", "pub use ", "pub(crate) use ", "pub(super) use "]) {
        paths.extend(expand(&statement));
    }
    for start in ["crate::", "super::"] {
        for (at, _) in text.match_indices(start) {
            let end =
                text[at..].find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')).unwrap_or(text.len() - at);
            // A tree in braces belongs to a `use` statement.
            if !text[at + end..].starts_with(['{', '*']) {
                paths.push(text[at..at + end].to_owned());
            }
        }
    }
    let inside =
        paths.into_iter().filter(|path| ["crate", "super", "self"].iter().any(|start| path.starts_with(start)));
    inside.map(|path| resolve(module, &path)).collect()
}

/// The bodies of all statements that begin a line with one of `starts`.
fn statements(text: &str, starts: &[&str]) -> Vec<String> {
    let mut found = Vec::new();
    let mut rest = text;
    while let Some((line, after)) = rest.split_once('\n').or(Some((rest, ""))).filter(|_| !rest.is_empty()) {
        match starts.iter().find_map(|start| line.trim_start().strip_prefix(start)) {
            Some(_) => {
                let whole = rest.trim_start();
                let begin = whole.find("use ").map_or(0, |at| at + 4);
                let end = whole.find(';').unwrap_or(whole.len());
                found.push(whole[begin..end].split_whitespace().collect::<Vec<_>>().join(" "));
                rest = &whole[end..];
            }
            None => rest = after,
        }
    }
    found
}

/// The single paths of a tree: `a::{b, c::d}` is `a::b` and `a::c::d`.
fn expand(tree: &str) -> Vec<String> {
    let Some(open) = tree.find('{') else { return vec![tree.trim().trim_end_matches("::self").to_owned()] };
    let prefix = &tree[..open];
    let inner = tree[open + 1..].trim_end().trim_end_matches('}');
    let mut depth = 0;
    let mut parts = vec![String::new()];
    for c in inner.chars() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(String::new());
                continue;
            }
            _ => {}
        }
        parts.last_mut().expect("never empty").push(c);
    }
    let closed = |part: &str| part.to_owned() + &"}".repeat(part.matches('{').count() - part.matches('}').count());
    let parts = parts.iter().map(|part| part.trim()).filter(|part| !part.is_empty());
    parts.flat_map(|part| expand(&format!("{prefix}{}", closed(part)))).collect()
}

/// A path with `crate`, `super` and `self` resolved, as seen from `module`; without `crate`.
fn resolve(module: &str, path: &str) -> String {
    let mut base: Vec<&str> = module.split("::").filter(|part| !part.is_empty()).collect();
    let mut parts = path.split("::").peekable();
    while let Some(part) = parts.peek() {
        match *part {
            "crate" => base.clear(),
            "super" => _ = base.pop(),
            "self" => {}
            _ => break,
        }
        parts.next();
    }
    base.into_iter().chain(parts).collect::<Vec<_>>().join("::")
}

/// A re-exported path from the root of the crate; one of a module beside is given without `self`.
fn absolute(module: &str, path: &str, texts: &BTreeMap<String, String>) -> String {
    if ["crate", "super", "self"].iter().any(|start| path.split("::").next() == Some(start)) {
        return resolve(module, path);
    }
    let child = if module.is_empty() { path.to_owned() } else { format!("{module}::{path}") };
    let first = path.split("::").next().unwrap_or_default();
    let inner = if module.is_empty() { first.to_owned() } else { format!("{module}::{first}") };
    if texts.contains_key(&inner) { child } else { path.to_owned() }
}

/// The module that defines the last name of `path`: the longest module on it, with re-exports followed.
fn defining_module(
    path: &str,
    texts: &BTreeMap<String, String>,
    exports: &BTreeMap<(String, String), String>,
) -> Option<String> {
    let mut path = path.split(" as ").next().unwrap_or(path).to_owned();
    for _ in 0..8 {
        let parts: Vec<&str> = path.split("::").collect();
        let end = (0..=parts.len()).rev().find(|&end| texts.contains_key(&parts[..end].join("::")))?;
        let module = parts[..end].join("::");
        let Some(name) = parts.get(end) else { return Some(module).filter(|module| !is_face(&texts[module])) };
        match exports.get(&(module.clone(), (*name).to_owned())) {
            Some(target) => {
                path =
                    [target.as_str()].into_iter().chain(parts[end + 1..].iter().copied()).collect::<Vec<_>>().join("::")
            }
            None => return Some(module).filter(|module| !is_face(&texts[module])),
        }
    }
    None
}

#[test]
fn a_circle_is_found() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("a written file");
    write("lib.rs", "mod a;\nmod b;\npub use a::A;\n");
    write("a.rs", "use crate::b::{self, B};\npub struct A;\n");
    write("b.rs", "pub struct B;\n");
    assert_eq!(Source::read(folder.path()).circle(), None);
    write("b.rs", "pub struct B;\nfn f() -> crate::A { crate::A }\n");
    assert_eq!(Source::read(folder.path()).circle(), Some(vec!["a".into(), "b".into(), "a".into()]));
}
