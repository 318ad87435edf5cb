//! Files of one package import each other in no circle: whoever reads one downwards comes to an end.
//!
//! What a file imports are the paths in it (`use` among them) that lead to something of another file of its package, followed through
//! whatever hands it on: `pub use` by itself is no import. What is compiled for tests alone may look around freely.

use std::collections::{BTreeMap, BTreeSet};

use crate::house::{complain, sources};

/// Names that were handed on more often than this lead nowhere: they hand each other on.
const HANDED_ON: usize = 20;

/// The files of one package: `(path inside it, text)`.
type Texts<'t> = [(String, &'t str)];

/// From file to file, by which names.
type Imports = BTreeMap<(usize, usize), BTreeSet<String>>;

/// One file, as one module of its package.
struct Module {
    place: Vec<String>,
    /// What `use` calls something here, and which path that is.
    names: Vec<(String, Vec<String>)>,
    /// Paths of which everything is named here.
    globs: Vec<Vec<String>>,
    /// What is declared here, and, by macros, as `Name = …`.
    declares: BTreeSet<String>,
    /// Every path, those that `pub use` only hands on left out.
    paths: Vec<Vec<String>>,
}

struct Package {
    modules: Vec<Module>,
    files: BTreeMap<Vec<String>, usize>,
}

impl Package {
    fn read(texts: &Texts) -> Self {
        let modules: Vec<Module> =
            texts.iter().map(|(path, text)| Module::read(place(path), &shipped(tokens(text)))).collect();
        let files = modules.iter().enumerate().map(|(file, module)| (module.place.clone(), file)).collect();
        Self { modules, files }
    }

    fn imports(&self) -> Imports {
        let mut imports = Imports::new();
        for (file, module) in self.modules.iter().enumerate() {
            for path in &module.paths {
                if let Some((other, name)) = self.named(file, path, 0)
                    && other != file
                {
                    imports.entry((file, other)).or_default().insert(name);
                }
            }
        }
        imports
    }

    /// The file that holds what a path names that is written in `file`, and its name there; nothing for whole modules and what is not of
    /// this package.
    fn named(&self, file: usize, path: &[String], handed_on: usize) -> Option<(usize, String)> {
        let module = &self.modules[file];
        let (first, rest) = path.split_first()?;
        match first.as_str() {
            "crate" => self.below(Vec::new(), rest, handed_on),
            "self" => self.below(module.place.clone(), rest, handed_on),
            "super" => {
                let mut place = module.place.clone();
                let up = path.iter().take_while(|segment| *segment == "super").count();
                place.truncate(place.len().checked_sub(up)?);
                self.below(place, &path[up..], handed_on)
            }
            _ => {
                let is_named = module.names.iter().any(|(name, _)| name == first);
                let is_module =
                    self.files.contains_key(&[&module.place[..], std::slice::from_ref(first)].concat());
                let starts_here = is_named || is_module || !module.globs.is_empty();
                starts_here.then(|| self.below(module.place.clone(), path, handed_on)).flatten()
            }
        }
    }

    /// As [`Self::named`], from a module on.
    fn below(&self, mut place: Vec<String>, path: &[String], handed_on: usize) -> Option<(usize, String)> {
        let (first, rest) = path.split_first()?;
        if handed_on > HANDED_ON {
            return None;
        }
        let &file = self.files.get(&place)?;
        let module = &self.modules[file];
        let through = |path: &[String]| {
            // A name is not looked up by itself again.
            let is_other = path.first().is_some_and(|one| one != first || rest.is_empty() && path.len() > 1);
            is_other.then(|| self.named(file, path, handed_on + 1)).flatten()
        };
        let mut handed = module.names.iter().filter(|(name, _)| name == first);
        // A module and what it holds can have one name; only the module has something inside.
        place.push(first.clone());
        if self.files.contains_key(&place) {
            return match rest {
                [] => handed.find_map(|(_, path)| through(path)),
                _ => self.below(place, rest, handed_on),
            };
        }
        if let Some((_, path)) = handed.next() {
            return through(&[path, rest].concat());
        }
        if module.declares.contains(first) {
            return Some((file, first.clone()));
        }
        let has = |other: &usize| {
            let Module { declares, names, .. } = &self.modules[*other];
            declares.contains(first) || names.iter().any(|(name, _)| name == first)
        };
        match module.globs.iter().filter_map(|glob| self.module(file, glob)).find(has) {
            Some(other) => self.below(self.modules[other].place.clone(), path, handed_on + 1),
            None => Some((file, first.clone())),
        }
    }

    /// The module that a path names that is written in `file`.
    fn module(&self, file: usize, path: &[String]) -> Option<usize> {
        let mut place = self.modules[file].place.clone();
        for segment in path {
            match segment.as_str() {
                "crate" => place.clear(),
                "self" => {}
                "super" => drop(place.pop()),
                name => place.push(name.to_string()),
            }
        }
        self.files.get(&place).copied()
    }
}

impl Module {
    fn read(place: Vec<String>, tokens: &[&str]) -> Self {
        let declares = tokens.windows(4).filter_map(|four| match four {
            ["fn" | "struct" | "enum" | "trait" | "type" | "const" | "static", name, ..] => {
                Some(name.to_string())
            }
            [name, "=", of, "{" | "|"] if name.starts_with(char::is_uppercase) && is_word(of) => {
                Some(name.to_string())
            }
            _ => None,
        });
        let (names, globs, paths) = (Vec::new(), Vec::new(), Vec::new());
        let mut module = Self { place, names, globs, declares: declares.collect(), paths };
        // Of modules that are written in the file itself, how many braces are open around each.
        let (mut inline, mut depth, mut inside) = (Vec::new(), 0, BTreeSet::new());
        let (mut at, mut is_public) = (0, false);
        while at < tokens.len() {
            match tokens[at] {
                // Not `impl Trait + use<'a>`.
                "use" if tokens[at + 1] != "<" => {
                    let end = at + tokens[at..].iter().position(|token| *token == ";").unwrap();
                    let (named, globs, paths) = (module.names.len(), module.globs.len(), module.paths.len());
                    module.import(&[], &tokens[at + 1..end], is_public);
                    module.names[named..].iter_mut().for_each(|(_, path)| outwards(path, inline.len()));
                    module.globs[globs..].iter_mut().for_each(|path| outwards(path, inline.len()));
                    module.paths[paths..].iter_mut().for_each(|path| outwards(path, inline.len()));
                    at = end;
                }
                "mod" if tokens.get(at + 2) == Some(&"{") => {
                    inline.push(depth);
                    inside.insert(tokens[at + 1]);
                }
                "{" => depth += 1,
                "}" => {
                    depth -= 1;
                    inline.pop_if(|around| *around == depth);
                }
                word if is_word(word) && (at == 0 || !["::", "."].contains(&tokens[at - 1])) => {
                    let mut path = path(&tokens[at..]);
                    let end = at + 2 * path.len() - 1;
                    // `pub(crate)` goes on to whatever is public.
                    let goes_on = is_public && ["crate", "super", "in", "self"].contains(&word);
                    is_public = word == "pub" || goes_on;
                    // Variables are often called like a function that is not meant.
                    let is_called = tokens.get(end).is_some_and(|next| ["(", "!"].contains(next));
                    if path.len() > 1 || is_called || !word.starts_with(char::is_lowercase) {
                        outwards(&mut path, inline.len());
                        module.paths.push(path);
                    }
                    at = end - 1;
                }
                "(" | ")" => {}
                _ => is_public = false,
            }
            at += 1;
        }
        // All that is in the file counts as the file's own.
        for path in &mut module.paths {
            let count = path.iter().take_while(|segment| inside.contains(segment.as_str())).count();
            path.drain(..count.min(path.len() - 1));
        }
        module
    }

    /// Reads what stands behind `use`, or a part of it behind `before`.
    fn import(&mut self, before: &[String], tree: &[&str], is_public: bool) {
        // Of another package.
        if tree.first() == Some(&"::") {
            return;
        }
        let path = path(tree);
        let mut whole = [before, &path].concat();
        let rest = &tree[(2 * path.len()).saturating_sub(1).min(tree.len())..];
        match rest {
            ["::", "*"] | ["*"] => self.globs.push(whole),
            ["::", "{", group @ .., "}"] | ["{", group @ .., "}"] => {
                for part in parts(group).into_iter().filter(|part| !part.is_empty()) {
                    self.import(&whole, part, is_public);
                }
            }
            _ => {
                if whole.len() > 1 && whole.last().is_some_and(|last| last == "self") {
                    whole.pop();
                }
                let name = match rest {
                    ["as", name] => name.to_string(),
                    _ => whole.last().unwrap().clone(),
                };
                if !is_public {
                    self.paths.push(whole.clone());
                }
                self.names.push((name, whole));
            }
        }
    }
}

/// Where a path leads that is written in so many modules inside of a file, as seen from the file.
fn outwards(path: &mut Vec<String>, inline: usize) {
    let up = path.iter().take_while(|segment| *segment == "super").count();
    if inline > 0 && up > 0 {
        path.drain(..up.min(inline));
        if up <= inline {
            path.insert(0, "self".to_string());
        }
    }
}

/// What a group of `use` consists of.
fn parts<'a, 't>(group: &'a [&'t str]) -> Vec<&'a [&'t str]> {
    let mut depth = 0;
    let comma = |token: &&str| {
        depth += i32::from(*token == "{") - i32::from(*token == "}");
        *token == "," && depth == 0
    };
    group.split(comma).collect()
}

/// The words that `::` joins, from the first token on.
fn path(tokens: &[&str]) -> Vec<String> {
    let mut path = Vec::new();
    let mut rest = tokens;
    while let [word, ..] = rest
        && is_word(word)
    {
        path.push(word.to_string());
        match &rest[1..] {
            ["::", further @ ..] => rest = further,
            _ => break,
        }
    }
    path
}

fn is_word(token: &str) -> bool {
    token.starts_with(|one: char| one.is_alphabetic() || one == '_')
}

/// Where in its package the module of a file is.
fn place(file: &str) -> Vec<String> {
    let mut place: Vec<String> = file.trim_end_matches(".rs").split('/').map(str::to_string).collect();
    if ["mod", "lib"].contains(&place.last().unwrap().as_str()) {
        place.pop();
    }
    place
}

/// What a program consists of, without comments, texts, numbers and lifetimes: words, `::`, and other characters each by itself.
fn tokens(text: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(one) = rest.chars().next() {
        let length = literal(rest).unwrap_or_else(|| {
            let is_of_word = |one: char| one.is_alphanumeric() || one == '_';
            let length = match one {
                ':' if rest.starts_with("::") => 2,
                _ if is_of_word(one) => rest.find(|one| !is_of_word(one)).unwrap_or(rest.len()),
                _ => one.len_utf8(),
            };
            if !one.is_whitespace() && !one.is_numeric() {
                tokens.push(&rest[..length]);
            }
            length
        });
        // `#[serde(with = "…")]` names a module.
        if one == '"' && tokens.ends_with(&["with", "="]) {
            tokens.extend(self::tokens(&rest[1..length - 1]));
            tokens.extend(["::", "serialize"]);
        }
        rest = &rest[length..];
    }
    tokens
}

/// The length of a comment, a text, a character or a lifetime that stands first.
fn literal(text: &str) -> Option<usize> {
    let until =
        |from: usize, end: &str| text[from..].find(end).map_or(text.len(), |at| from + at + end.len());
    let raw = text.strip_prefix("br").or_else(|| text.strip_prefix('r'));
    let raw = raw.and_then(|raw| raw.trim_start_matches('#').strip_prefix('"').map(|inside| (raw, inside)));
    if let Some((raw, inside)) = raw {
        let from = text.len() - inside.len();
        return Some(until(from, &format!("\"{}", "#".repeat(raw.len() - inside.len() - 1))));
    }
    if text.starts_with("//") {
        return Some(text.find('\n').unwrap_or(text.len()));
    }
    if text.starts_with("/*") {
        return Some(until(2, "*/"));
    }
    let quoted = text.strip_prefix('b').filter(|rest| rest.starts_with(['"', '\''])).unwrap_or(text);
    let start = text.len() - quoted.len() + 1;
    let quote = quoted.chars().next().filter(|one| ['"', '\''].contains(one))?;
    let mut inside = quoted[1..].chars();
    let is_lifetime = quote == '\'' && inside.next() != Some('\\') && inside.next() != Some('\'');
    if is_lifetime {
        let end = text[1..].find(|one: char| !one.is_alphanumeric() && one != '_');
        return Some(end.map_or(text.len(), |end| end + 1));
    }
    let mut is_escaped = false;
    for (at, one) in text[start..].char_indices() {
        match one {
            _ if is_escaped => is_escaped = false,
            '\\' => is_escaped = true,
            _ if one == quote => return Some(start + at + 1),
            _ => {}
        }
    }
    Some(text.len())
}

/// Without what is compiled for tests alone: the item behind each `#[cfg(test)]`.
fn shipped(tokens: Vec<&str>) -> Vec<&str> {
    const FOR_TESTS: [&[&str]; 2] =
        [&["#", "[", "cfg", "(", "test", ")", "]"], &["#", "[", "cfg", "(", "all", "(", "test"]];
    let mut shipped = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        if FOR_TESTS.iter().any(|test| tokens[at..].starts_with(test)) {
            let mut depth = 0;
            let ends = |token: &&str| {
                depth +=
                    i32::from(["{", "(", "["].contains(token)) - i32::from(["}", ")", "]"].contains(token));
                depth == 0 && ["}", ";"].contains(token)
            };
            at += tokens[at..].iter().position(ends).map_or(tokens.len(), |end| end + 1);
        } else {
            shipped.push(tokens[at]);
            at += 1;
        }
    }
    shipped
}

/// Every circle of files that import each other, with the names that tie them.
fn circles(texts: &Texts) -> Vec<String> {
    let imports = Package::read(texts).imports();
    let mut reached: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); texts.len()];
    for (file, reached) in reached.iter_mut().enumerate() {
        let mut open = vec![file];
        while let Some(next) = open.pop() {
            let others = imports.keys().filter(|(from, _)| *from == next).map(|(_, to)| *to);
            open.extend(others.filter(|other| reached.insert(*other)));
        }
    }
    let circle_of = |file: usize| -> Vec<usize> {
        reached[file].iter().copied().filter(|other| reached[*other].contains(&file)).collect()
    };
    let circles: BTreeSet<Vec<usize>> =
        (0..texts.len()).map(circle_of).filter(|circle| !circle.is_empty()).collect();
    let tied = |circle: Vec<usize>| {
        let within = imports.iter().filter(|((from, to), _)| circle.contains(from) && circle.contains(to));
        let lines = within.map(|((from, to), names)| {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            format!("    {} -> {}: {}", texts[*from].0, texts[*to].0, names.join(", "))
        });
        format!("{} files import each other:\n{}", circle.len(), lines.collect::<Vec<_>>().join("\n"))
    };
    circles.into_iter().map(tied).collect()
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let sources = sources();
    let mut packages: BTreeMap<&str, Vec<(String, &str)>> = BTreeMap::new();
    for source in &sources {
        let path = source.path.to_string_lossy().replace('\\', "/");
        // The program is no part of the library beside it.
        if path != "main.rs" {
            let inside = path.strip_prefix(&format!("{}/", source.package)).unwrap_or(&path).to_string();
            packages.entry(&source.package).or_default().push((inside, &source.text));
        }
    }
    let broken = packages.into_iter().flat_map(|(package, texts)| {
        circles(&texts).into_iter().map(move |circle| format!("{package}: {circle}"))
    });
    complain(broken.collect());
}

mod of_made_up_files {
    use super::*;

    /// The circles of made-up files.
    fn of(files: &[(&str, &str)]) -> Vec<String> {
        let texts: Vec<(String, &str)> = files.iter().map(|(path, text)| (path.to_string(), *text)).collect();
        circles(&texts)
    }

    #[test]
    fn two_files_that_import_each_other_are_named_with_what_ties_them() {
        let found = of(&[
            ("lib.rs", "mod a;\nmod b;\nmod c;\npub use a::One;\n"),
            ("a.rs", "use super::b::two;\npub struct One;\nfn go() { two() }\n"),
            ("b.rs", "use super::c;\nuse crate::One;\npub fn two() -> One { c::three() }\n"),
            ("c.rs", "pub fn three() {}\n"),
        ]);
        let said = "2 files import each other:\n    a.rs -> b.rs: two\n    b.rs -> a.rs: One";
        assert_eq!(found, [said]);
    }

    #[test]
    fn longer_ways_round_are_circles_too() {
        let found = of(&[
            ("lib.rs", "mod a;\nmod b;\nmod c;\nmod d;\n"),
            ("a.rs", "fn one() { crate::b::two() }"),
            ("b.rs", "pub fn two() { super::c::Three::new() }"),
            ("c.rs", "use super::d::{self, Four as Other};\npub struct Three(Other);\n"),
            ("d.rs", "pub struct Four;\nfn five() -> super::a::One {}"),
        ]);
        assert_eq!(found.len(), 1);
        assert!(
            found[0].starts_with("4 files") && found[0].contains("    c.rs -> d.rs: Four\n"),
            "{found:?}"
        );
    }

    #[test]
    fn a_parent_that_its_children_use_must_not_use_them() {
        let child = ("x/y.rs", "use super::Shared;\npub fn made() -> Shared { Shared }\n");
        let uses = "mod y;\npub struct Shared;\nfn go() { y::made() }\n";
        assert_eq!(of(&[("x/mod.rs", uses), child]).len(), 1);
        // Handing on what a child has is not using it.
        for hands_on in
            ["mod y;\npub use y::made;\npub struct Shared;\n", "mod y;\npub use y::*;\npub struct Shared;\n"]
        {
            assert!(of(&[("x/mod.rs", hands_on), child]).is_empty(), "{hands_on}");
        }
        let called = "mod y;\npub(crate) use y::made;\npub struct Shared;\nfn go() { made() }\n";
        assert_eq!(of(&[("x/mod.rs", called), child]).len(), 1);
        assert_eq!(of(&[("x/mod.rs", "mod y;\nuse y::made;\npub struct Shared;\n"), child]).len(), 1);
    }

    #[test]
    fn names_are_followed_to_where_they_are_declared() {
        // Through a `use` of whole modules, another name, a module inside of the file and `with` of serde.
        for text in [
            "use super::x::{self};\nfn go() { x::y::made() }",
            "use crate::x::made as other;\nfn go() { other() }",
            "mod inside {\n    pub use super::super::x::made;\n}\nfn go() { inside::made() }",
            "struct S {\n    #[serde(with = \"super::x::y\")]\n    a: u8,\n}",
            "use super::x::*;\nfn go() { made() }",
        ] {
            let files = [
                ("lib.rs", "mod x;\nmod b;\n"),
                ("b.rs", text),
                ("x/mod.rs", "pub mod y;\npub use y::made;\n"),
                ("x/y.rs", "use crate::b::S;\npub fn made() {}\npub fn serialize() {}\n"),
            ];
            let found = of(&files);
            assert!(found.len() == 1 && found[0].contains("b.rs -> x/y.rs"), "{text}: {found:?}");
        }
    }

    #[test]
    fn what_is_for_tests_and_what_is_said_imports_nothing() {
        for text in [
            "#[cfg(test)]\nmod tests {\n    use crate::b::Two;\n}\n",
            "#[cfg(test)]\nuse crate::b::Two;\n",
            "#[cfg(all(test, unix))]\nmod tests {\n    use crate::b::Two;\n}\n",
            "// crate::b::Two\n/* crate::b::Two */\n/// [`crate::b::Two`]\nfn one() {}\n",
            "fn one() -> &'static str { let _ = '\"'; \"crate::b::Two\" }\n",
            "fn one<'b>() -> &'b str { r#\"\"crate::b::Two\"\"# }\n",
            "fn one() -> impl Sized + use<> { ::b::Two }\n",
            "use ::b::Two;\nuse rayon::prelude::*;\nfn one() { b.Two() }\n",
        ] {
            let files = [
                ("lib.rs", "mod a;\nmod b;\n"),
                ("a.rs", text),
                ("b.rs", "use super::a::one;\npub struct Two;\n"),
            ];
            assert_eq!(of(&files), [""; 0], "{text}");
        }
    }
}
