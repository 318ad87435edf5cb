//! Suites of one name in one invocation: what stands before the names in their keys, so that no two keys are the same.

use std::collections::HashMap;
use std::path::{Component, Path};

/// Of suites, each given by its file and name, what stands before the name in keys: nothing where no other has it, and else the shortest end
/// of the path that tells them apart, with a slash.
pub fn key_prefixes(suites: &[(&str, &str)]) -> Vec<String> {
    let mut of_name: HashMap<&str, Vec<usize>> = HashMap::new();
    for (index, (_, name)) in suites.iter().enumerate() {
        of_name.entry(name).or_default().push(index);
    }
    let mut prefixes = vec![String::new(); suites.len()];
    for group in of_name.values().filter(|group| group.len() > 1) {
        let files: Vec<&Path> = group.iter().map(|index| Path::new(suites[*index].0)).collect();
        for (index, prefix) in group.iter().zip(told_apart(&files)) {
            prefixes[*index] = prefix;
        }
    }
    prefixes
}

/// The folders first; where they do not tell files apart, their names as well, and then with their endings.
fn told_apart(files: &[&Path]) -> Vec<String> {
    let wholes = [
        files.iter().map(|file| folders(file)).collect::<Vec<_>>(),
        files.iter().map(|file| [folders(file), words([file.file_stem()])].concat()).collect(),
        files.iter().map(|file| [folders(file), words([file.file_name()])].concat()).collect(),
    ];
    for paths in &wholes {
        let longest = paths.iter().map(Vec::len).max().unwrap_or(0);
        for length in 1..=longest {
            let ends = paths.iter().map(|path| end(path, length)).collect::<Vec<_>>();
            let is_new = |(index, one): (usize, &String)| !ends[..index].contains(one);
            if ends.iter().enumerate().all(is_new) {
                return ends;
            }
        }
    }
    // The same file twice, which is opened once only.
    files.iter().map(|_| String::new()).collect()
}

/// The last so many parts of a path, each with a slash behind it.
fn end(path: &[String], length: usize) -> String {
    path[path.len().saturating_sub(length)..].iter().map(|part| format!("{part}/")).collect()
}

fn folders(file: &Path) -> Vec<String> {
    let parts = file.parent().into_iter().flat_map(Path::components);
    words(parts.map(|part| match part {
        Component::Normal(_) | Component::ParentDir => Some(part.as_os_str()),
        Component::CurDir | Component::RootDir | Component::Prefix(_) => None,
    }))
}

fn words<'p>(parts: impl IntoIterator<Item = Option<&'p std::ffi::OsStr>>) -> Vec<String> {
    parts.into_iter().flatten().map(|part| part.to_string_lossy().into_owned()).collect()
}

/// A key of a suite that is alone, of what it was called where others of its name were: without the end of the path of its file before it.
/// `None` if it begins otherwise.
pub(super) fn key_alone<'k>(key: &'k str, file: &str, name: &str) -> Option<&'k str> {
    let file = Path::new(file);
    let (folders, stem, whole) = (folders(file), words([file.file_stem()]), words([file.file_name()]));
    [folders.clone(), [folders.clone(), stem].concat(), [folders, whole].concat()].iter().find_map(|path| {
        (1..=path.len()).find_map(|length| {
            let rest = key.strip_prefix(end(path, length).as_str())?;
            rest.strip_prefix(name)?.starts_with('/').then_some(rest)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn prefixes(suites: &[(&str, &str)]) -> Vec<String> {
        key_prefixes(suites)
    }

    #[test]
    fn the_shortest_end_of_the_path_tells_them_apart() {
        assert_eq!(prefixes(&[("a/zebra.suite", "zebra"), ("b/zebra.suite", "zebra")]), ["a/", "b/"]);
        assert_eq!(prefixes(&[("x/a/s.suite", "s"), ("y/a/s.suite", "s")]), ["x/a/", "y/a/"]);
        // Others keep their keys.
        assert_eq!(prefixes(&[("a/s.scn", "s"), ("a/t.scn", "t"), ("b/s.scn", "s")]), ["a/", "", "b/"]);
        assert_eq!(prefixes(&[("s.suite", "s"), ("./a/s.suite", "s")]), ["", "a/"]);
        assert_eq!(prefixes(&[("../a/s.suite", "s"), ("/root/b/s.suite", "s")]), ["a/", "b/"]);
        // One folder, two files: their names tell; of one name, their endings.
        assert_eq!(prefixes(&[("a/one.suite", "s"), ("a/two.suite", "s")]), ["one/", "two/"]);
        assert_eq!(prefixes(&[("a/s.suite", "s"), ("a/s.scn", "s")]), ["s.suite/", "s.scn/"]);
        assert_eq!(prefixes(&[("a/s.scn", "s"), ("b/s.scn", "s"), ("c/b/s.scn", "s")]), ["a/", "b/", "c/b/"]);
    }

    #[test]
    fn a_key_is_known_where_its_suite_is_alone() {
        let alone = |key| key_alone(key, "x/a/zebra.suite", "zebra");
        assert_eq!(alone("a/zebra/s/rep=1"), Some("zebra/s/rep=1"));
        assert_eq!(alone("x/a/zebra/s"), Some("zebra/s"));
        assert_eq!(alone("zebra/zebra/s"), Some("zebra/s"));
        for other in ["zebra/s", "b/zebra/s", "a/zebras/s", "a/zebra"] {
            assert_eq!(alone(other), None, "{other}");
        }
    }
}
