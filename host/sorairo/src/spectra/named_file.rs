//! The name of a file that a scene reads.

use std::path::{Component, Path, PathBuf};

/// Where a file lies, and the name by which other files know it.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedFile {
    path: PathBuf,
    /// The name by which images and other files know it; see [`NamedFile::name_from`].
    name: PathBuf,
}

impl NamedFile {
    /// The file at a path.
    pub fn new(path: &Path) -> Self {
        let mut file = Self::nowhere(path);
        file.name_from(Path::new("."));
        file
    }

    /// The name of what is no file.
    pub(super) fn nowhere(name: &Path) -> Self {
        Self { path: name.to_owned(), name: name.to_owned() }
    }

    /// Where it lies.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Names it in files as it is found from a folder: that of the scene, which may move with it to another machine.
    /// Where the two have no folder in common its place tells of the machine alone, and its own name is left.
    pub(crate) fn name_from(&mut self, folder: &Path) {
        self.name = found_from(folder, &self.path).unwrap_or_else(|| self.path.clone());
    }

    /// Takes that name as its path.
    #[cfg(feature = "encoding")]
    pub(crate) fn go_by_name(&mut self) {
        self.path.clone_from(&self.name);
    }
}

/// The name of a file from a folder; none where there are no folders.
fn found_from(folder: &Path, file: &Path) -> Option<PathBuf> {
    let (folder, file) = (whole(folder)?, whole(file)?);
    let shared = folder.components().zip(file.components()).take_while(|(a, b)| a == b).map(|(shared, _)| shared);
    if !shared.clone().any(|part| matches!(part, Component::Normal(_))) {
        return file.file_name().map(PathBuf::from);
    }
    let shared = shared.count();
    let up = folder.components().skip(shared).map(|_| Component::ParentDir);
    Some(up.chain(file.components().skip(shared)).collect())
}

/// A path from the root, without steps back.
fn whole(path: &Path) -> Option<PathBuf> {
    let mut whole = PathBuf::new();
    for part in std::path::absolute(Path::new(".").join(path)).ok()?.components() {
        if part == Component::ParentDir {
            whole.pop();
        } else {
            whole.push(part);
        }
    }
    Some(whole)
}

/// Whether a value is the name of a CSV file.
pub(crate) fn is_table_file(text: &str) -> bool {
    Path::new(text).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"))
}

/// Whether a value is the name of a text file.
pub(crate) fn is_text_file(text: &str) -> bool {
    Path::new(text).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("txt"))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_named_as_it_is_found_from_the_scene() {
        for (folder, file, name) in [
            ("/a/scenes", "/a/scenes/x.csv", "x.csv"),
            ("/a/scenes", "/a/scenes/tables/x.csv", "tables/x.csv"),
            ("/a/scenes/", "/a/scenes/../tables/./x.csv", "../tables/x.csv"),
            ("/a/b/../scenes", "/a/tables/x.csv", "../tables/x.csv"),
            // As from a scene on standard input.
            ("/dev", "/a/x.csv", "x.csv"),
            (".", "tables/x.csv", "tables/x.csv"),
            ("", "x.csv", "x.csv"),
            ("scenes", "x.csv", "../x.csv"),
        ] {
            assert_eq!(found_from(Path::new(folder), Path::new(file)).unwrap(), Path::new(name), "{folder} {file}");
        }
    }
}
