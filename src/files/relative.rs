//! How one file names another.

use std::path::{Component, Path, PathBuf};

/// `target`, as a file in `folder` names it: both as they are named from where the program was started, which is the empty folder, too. By the names alone, without looking
/// whether anything is there; on another drive it keeps its whole path.
pub fn relative(target: &Path, folder: &Path) -> PathBuf {
    let (target, folder) = (whole(target), whole(folder));
    let (to, from): (Vec<_>, Vec<_>) = (target.components().collect(), folder.components().collect());
    let common = to.iter().zip(&from).take_while(|(one, other)| one == other).count();
    if common == 0 {
        return target;
    }
    let up = std::iter::repeat_n(Component::ParentDir, from.len() - common);
    up.chain(to[common..].iter().copied()).collect()
}

/// From the root on, without `.` and `..`.
fn whole(path: &Path) -> PathBuf {
    // What has no name, as the parent of `a.scn`, is where the program was started.
    let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let mut whole = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => {
                whole.pop();
            }
            Component::CurDir => {}
            part => whole.push(part),
        }
    }
    whole
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_named_from_where_another_lies() {
        let named = |target: &str, folder: &str| relative(Path::new(target), Path::new(folder));
        assert_eq!(named("a.scn", "."), Path::new("a.scn"));
        assert_eq!(named("a.scn", ""), Path::new("a.scn"));
        assert_eq!(named("in/a.scn", ""), Path::new("in/a.scn"));
        assert_eq!(named("a.scn", "out"), Path::new("../a.scn"));
        assert_eq!(named("in/a.scn", "in"), Path::new("a.scn"));
        assert_eq!(named("in/../a.scn", "./out/deep"), Path::new("../../a.scn"));
        assert_eq!(named("/x/a.scn", "/x/y"), Path::new("../a.scn"));
    }
}
