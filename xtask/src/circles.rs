//! `cargo xtask circles`: fails if files of a crate need each other in a circle.
//!
//! A file needs another one if it names something in it: in a `use` or by a path in the code that begins with `crate`,
//! `super`, `self` or a module of its own. What is for tests alone does not count, nor does `mod`, which only says that
//! a file is there.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::error::Error;
use std::fs;
use std::iter::Peekable;
use std::path::{Path, PathBuf};

use proc_macro2::token_stream::IntoIter;
use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};

/// Where the crates lie.
const FOLDERS: [&str; 5] = ["shared", "shader-crate", "host", "tests", "xtask"];

/// The path of a module in its crate, without the name of the crate.
type Module = Vec<String>;

/// Which modules each module needs; each module is a file.
type Needs = BTreeMap<Module, BTreeSet<Module>>;

/// Looks at every crate of the repository at `root`.
///
/// # Errors
///
/// The circles, a line each, or a file that cannot be read.
pub fn check(root: &Path) -> Result<String, Box<dyn Error>> {
    let mut sources = Vec::new();
    for folder in FOLDERS {
        find_sources(&root.join(folder), &mut sources)?;
    }
    let (mut files, mut found) = (0, Vec::new());
    for source in &sources {
        let needs = needs(&modules(source)?)?;
        files += needs.len();
        let shown = |module: &Module| if module.is_empty() { "(root)".to_owned() } else { module.join("::") };
        let line = |circle: &Vec<Module>| circle.iter().map(shown).collect::<Vec<_>>().join(" → ");
        let name = source.strip_prefix(root)?.display();
        found.extend(circles(&needs).iter().map(|circle| format!("{name}: {}", line(circle))));
    }
    if found.is_empty() {
        return Ok(format!("{files} files of {} crates need each other in no circle", sources.len()));
    }
    Err(format!("files need each other in circles:\n{}", found.join("\n")).into())
}

/// The source folders of the crates in a folder.
fn find_sources(folder: &Path, sources: &mut Vec<PathBuf>) -> Result<(), Box<dyn Error>> {
    if folder.join("Cargo.toml").is_file() && folder.join("src").is_dir() {
        sources.push(folder.join("src"));
    }
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() && !path.ends_with("src") {
            find_sources(&path, sources)?;
        }
    }
    Ok(())
}

/// The modules in a source folder, with their code.
fn modules(source: &Path) -> Result<BTreeMap<Module, String>, Box<dyn Error>> {
    let mut modules = BTreeMap::new();
    let mut folders = vec![source.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder)? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let name = path.strip_prefix(source)?.with_extension("");
                let mut module: Module = name.iter().map(|part| part.to_string_lossy().into_owned()).collect();
                module.pop_if(|last| ["lib", "main", "mod"].contains(&last.as_str()));
                // A command beside its library is in the same module; nobody needs it.
                modules.entry(module).or_insert_with(String::new).push_str(&fs::read_to_string(&path)?);
            }
        }
    }
    Ok(modules)
}

/// What each module needs, by its code.
fn needs(modules: &BTreeMap<Module, String>) -> Result<Needs, Box<dyn Error>> {
    let known: BTreeSet<&Module> = modules.keys().collect();
    let of = |(module, code): (&Module, &String)| {
        let code: TokenStream = code.parse().map_err(|error| format!("{}: {error}", module.join("::")))?;
        let mut paths = Vec::new();
        collect_paths(code, &mut paths);
        let needed = paths.iter().filter_map(|path| resolved(module, path, &known)).filter(|needed| needed != module);
        Ok((module.clone(), needed.collect()))
    };
    modules.iter().map(of).collect()
}

/// The module that a path in a module's code leads into, if it is one of the crate's.
fn resolved(module: &Module, path: &[String], known: &BTreeSet<&Module>) -> Option<Module> {
    let mut place = module.clone();
    let mut rest = path;
    match path[0].as_str() {
        "crate" => (place, rest) = (Module::new(), &path[1..]),
        "self" => rest = &path[1..],
        "super" => {
            while rest.first().is_some_and(|part| part == "super") {
                place.pop()?;
                rest = &rest[1..];
            }
        }
        name => {
            let child = [module.as_slice(), &[name.to_owned()]].concat();
            known.get(&child)?;
        }
    }
    for part in rest {
        place.push(part.clone());
        if !known.contains(&place) {
            place.pop();
            break;
        }
    }
    Some(place)
}

/// Every path in some code that is not for tests alone; a group at a path's end makes a path of each of its parts.
fn collect_paths(code: TokenStream, paths: &mut Vec<Module>) {
    let mut tokens = code.into_iter().peekable();
    let mut after_path = false;
    while let Some(token) = tokens.next() {
        match token {
            TokenTree::Punct(punct) if punct.as_char() == '#' => {
                if tokens.next().is_some_and(|token| token.to_string() == "[cfg (test)]") {
                    skip_item(&mut tokens);
                }
            }
            TokenTree::Ident(start) if !after_path => follow(vec![start.to_string()], &mut tokens, paths),
            TokenTree::Group(group) => collect_paths(group.stream(), paths),
            other => {
                after_path = other.to_string() == ":";
                continue;
            }
        }
        after_path = false;
    }
}

/// Reads on from the first part of a path to its end.
fn follow(mut path: Module, tokens: &mut Peekable<IntoIter>, paths: &mut Vec<Module>) {
    let is_colon = |token: &TokenTree| matches!(token, TokenTree::Punct(punct) if punct.as_char() == ':');
    loop {
        let mut ahead = tokens.clone();
        if !(ahead.next().as_ref().is_some_and(is_colon) && ahead.next().as_ref().is_some_and(is_colon)) {
            break;
        }
        match ahead.next() {
            Some(TokenTree::Ident(part)) => path.push(part.to_string()),
            Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Brace => {
                follow_group(&path, &group, paths);
                *tokens = ahead;
                return;
            }
            _ => break,
        }
        *tokens = ahead;
    }
    if path.len() > 1 {
        paths.push(path);
    }
}

/// The parts of a `use` group, each after the path before the group.
fn follow_group(path: &Module, group: &Group, paths: &mut Vec<Module>) {
    let mut tokens = group.stream().into_iter().peekable();
    while let Some(token) = tokens.next() {
        if let TokenTree::Ident(part) = token {
            let part = part.to_string();
            let whole = if part == "self" { path.clone() } else { [path.as_slice(), &[part]].concat() };
            follow(whole, &mut tokens, paths);
        }
    }
}

/// Leaves out an item: up to its braces or its semicolon.
fn skip_item(tokens: &mut Peekable<IntoIter>) {
    tokens.find(|token| match token {
        TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
        other => other.to_string() == ";",
    });
}

/// The shortest circle through each module that is in one; each circle once, from its first module back to it.
fn circles(needs: &Needs) -> Vec<Vec<Module>> {
    let mut seen = BTreeSet::new();
    let new = |circle: &Vec<Module>| seen.insert(circle.iter().cloned().collect::<BTreeSet<_>>());
    needs.keys().filter_map(|module| shortest_circle(needs, module)).filter(new).collect()
}

fn shortest_circle(needs: &Needs, start: &Module) -> Option<Vec<Module>> {
    let mut ways = VecDeque::from([vec![start.clone()]]);
    let mut reached = BTreeSet::new();
    while let Some(way) = ways.pop_front() {
        for next in &needs[way.last()?] {
            let longer = [way.as_slice(), std::slice::from_ref(next)].concat();
            if next == start {
                return Some(longer);
            }
            if reached.insert(next.clone()) {
                ways.push_back(longer);
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circles_of(files: &[(&str, &str)]) -> Vec<String> {
        let module =
            |name: &str| name.split("::").filter(|part| !part.is_empty()).map(str::to_owned).collect::<Module>();
        let modules = files.iter().map(|&(name, code)| (module(name), code.to_owned())).collect();
        let shown = |circle: &Vec<Module>| circle.iter().map(|module| module.join("::")).collect::<Vec<_>>().join(" ");
        circles(&needs(&modules).unwrap()).iter().map(shown).collect()
    }

    #[test]
    fn files_that_need_each_other_are_a_circle() {
        let files = [
            ("", "mod a; mod b;"),
            ("a", "use crate::b::{Thing, c::Other};"),
            ("b", "pub mod c; pub struct Thing;"),
            ("b::c", "fn f() -> u32 { super::super::a::X }"),
        ];
        assert_eq!(circles_of(&files), ["a b::c a"]);
    }

    #[test]
    fn a_door_that_its_rooms_come_in_by_is_a_circle() {
        let files = [("", "mod a; pub use a::{self, A};"), ("a", "use crate::A;")];
        assert_eq!(circles_of(&files), [" a "]);
    }

    #[test]
    fn paths_within_macros_and_bodies_count() {
        let files = [("a", "fn f() { println!(\"{}\", crate::b::X) }"), ("b", "fn f() { g(|x| super::a::X) }")];
        assert_eq!(circles_of(&files).len(), 1);
    }

    #[test]
    fn tests_other_crates_and_declared_modules_are_no_circle() {
        let files = [
            ("", "pub mod a; pub use a::A;"),
            (
                "a",
                "use other::a::b; use other::{a::C, b::D}; #[cfg(test)] mod tests { use crate::X; } const T: u8 = 0;",
            ),
            ("a::b", "use super::A; /* use crate::a; */ const S: &str = \"crate::a::b\";"),
        ];
        assert!(circles_of(&files).is_empty());
    }
}
