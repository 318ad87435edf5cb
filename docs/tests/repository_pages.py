#!/usr/bin/env python3
"""A preprocessor of mdBook: what pages link to outside of docs becomes pages of the book, at its end.

Pages in Markdown are shown as pages and their links followed, other files as blocks, notebooks as their cells, folders as lists of what is in
them. So the book needs no address of the repository, and works from a file system.
"""

import json
import pathlib
import posixpath
import re
import subprocess
import sys

sys.dont_write_bytecode = True
import markdown

ROOT = pathlib.Path(__file__).resolve().parents[2]
DOCS = "docs"
# Where these pages lie in the book.
PLACE = "repository"
LARGEST = 200_000


def tracked(root):
    """The files of the repository."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=root, capture_output=True, check=True
    )
    return {name for name in listed.stdout.decode().split("\0") if name and (root / name).is_file()}


def page_of(path):
    """The page of the book that shows a path of the repository."""
    inside = posixpath.relpath(path, DOCS)
    if not inside.startswith("../"):
        return inside
    return f"{PLACE}/{path}" if path.endswith(".md") else f"{PLACE}/{path}.md"


class Repository:
    def __init__(self, root, files):
        self.root, self.files = root, files
        self.folders = {posixpath.join(*parts[:count]) for parts in map(lambda name: name.split("/"), files) for count in range(1, len(parts))}
        # What is shown, in the order in which it was found, with its text.
        self.shown = {}

    def rewritten(self, path, text):
        """The text of a page with its links leading to pages of the book."""
        here = page_of(path)
        lines = text.split("\n")
        for number, _, _, target in markdown.links(text):
            new = self.link(path, here, target)
            if new != target:
                lines[number - 1] = lines[number - 1].replace(f"]({target})", f"]({new})")
        return "\n".join(lines)

    def link(self, path, here, target):
        if markdown.is_outside(target) or target.startswith("#"):
            return target
        to, anchor = markdown.resolved(path, target)
        if to == DOCS or to.startswith(f"{DOCS}/"):
            readme = f"{to}/README.md"
            page = posixpath.relpath(readme if readme in self.files else to, DOCS)
        elif to in self.files or to in self.folders:
            self.show(to)
            page = page_of(to)
        else:
            return target
        return posixpath.relpath(page, posixpath.dirname(here) or ".") + (f"#{anchor}" if anchor else "")

    def show(self, path):
        if path in self.shown:
            return
        self.shown[path] = ""
        self.shown[path] = self.folder(path) if path in self.folders else self.file(path)

    def folder(self, path):
        inside = sorted(name for name in self.files if posixpath.dirname(name) == path)
        items = []
        for name in inside:
            self.show(name)
            items.append(f"- [`{posixpath.basename(name)}`]({posixpath.relpath(page_of(name), posixpath.dirname(page_of(path)))})")
        return f"# {path}\n\nA folder of the repository.\n\n" + "\n".join(items) + "\n"

    def file(self, path):
        raw = (self.root / path).read_bytes()
        if len(raw) > LARGEST:
            raise SystemExit(f"{path} is linked to and has {len(raw)} bytes: too long for a page")
        text = raw.decode("utf-8")
        if path.endswith(".md"):
            return self.rewritten(path, text)
        if path.endswith(".ipynb"):
            return f"# {path}\n\nA notebook of the repository.\n\n" + notebook(json.loads(text))
        return f"# {path}\n\nA file of the repository.\n\n" + block(text, language(path))


def language(path):
    return {".py": "python", ".rs": "rust,ignore", ".yml": "yaml", ".h": "c"}.get(pathlib.PurePosixPath(path).suffix, "text")


def block(text, language):
    fence = "`" * max([3, *(len(run) + 1 for run in re.findall("`{3,}", text))])
    return f"{fence}{language}\n{text.rstrip()}\n{fence}\n"


def notebook(content):
    """Cells without what they printed."""
    cells = (("".join(cell["source"]), cell["cell_type"]) for cell in content["cells"])
    return "\n\n".join(text if kind == "markdown" else block(text, "python") for text, kind in cells) + "\n"


def chapters(items):
    for item in items:
        if isinstance(item, dict) and "Chapter" in item:
            yield item["Chapter"]
            yield from chapters(item["Chapter"]["sub_items"])


def main(arguments):
    if arguments[:1] == ["supports"]:
        return 0 if arguments[1:] == ["html"] else 1
    _, book = json.load(sys.stdin)
    repository = Repository(ROOT, tracked(ROOT))
    items = book["items"]
    for chapter in chapters(items):
        if chapter["path"]:
            chapter["content"] = repository.rewritten(f"{DOCS}/{chapter['path']}", chapter["content"])
    if repository.shown:
        items.append({"PartTitle": "Files of the repository"})
    for path, content in sorted(repository.shown.items()):
        chapter = {"name": path, "content": content, "number": None, "sub_items": [], "parent_names": []}
        items.append({"Chapter": {**chapter, "path": page_of(path), "source_path": None}})
    json.dump(book, sys.stdout)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
