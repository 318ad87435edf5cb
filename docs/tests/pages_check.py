#!/usr/bin/env python3
"""Whether the pages hang together, in the repository and in the built book; `book` calls it.

    docs/tests/pages_check.py pages          every page of docs is in SUMMARY.md once and the other way round; links, anchors and pictures lead somewhere
    docs/tests/pages_check.py book FOLDER    the same of the built book: links, anchors, pictures, styles and scripts, and nothing that is fetched

What cannot be looked at is an error. `pages_refusals.py` has pages and books that have to be refused; they are tried first.
"""

import html.parser
import pathlib
import posixpath
import re
import sys
import tempfile
import urllib.parse

sys.dont_write_bytecode = True
import markdown
import pages_refusals
from repository_pages import DOCS, ROOT, tracked

SUMMARY = f"{DOCS}/SUMMARY.md"
# Of this folder nothing is a page.
TESTS = f"{DOCS}/tests/"
# Pages outside of docs that are read where they lie. Those of templates are read in the projects that they become part of.
OTHERS = re.compile(r"(?!docs/|templates/|target/).*\.md")


def pages_of(files):
    return sorted(name for name in files if name.startswith(f"{DOCS}/") and name.endswith(".md") and not name.startswith(TESTS) and name != SUMMARY)


def summary_problems(root, files):
    """Pages that the summary lacks, has twice, or has and are not there."""
    if SUMMARY not in files:
        yield f"{SUMMARY}: is not there"
        return
    listed = []
    for number, _, _, target in markdown.links(read(root, SUMMARY)):
        to, anchor = markdown.resolved(SUMMARY, target)
        if not target or anchor or markdown.is_outside(target) or to not in files:
            yield f"{SUMMARY}:{number}: `{target}` is no page"
        if to in listed:
            yield f"{SUMMARY}:{number}: `{target}` is there twice"
        listed.append(to)
    for page in pages_of(files):
        if page not in listed:
            yield f"{page}: is not in {SUMMARY}"


def read(root, name):
    return (root / name).read_text(encoding="utf-8")


def not_understood(text):
    """Lines with a link or picture of a kind that is not looked at."""
    for number, line in markdown.prose(text):
        line = markdown.without_code(line)
        if re.match(r"\s*\[[^\]]+\]:\s", line):
            yield number, "a link by reference: write `[text](target)`"
        if re.search(r"<(a|img)\b", line, re.IGNORECASE):
            yield number, "a link or a picture in HTML: write `[text](target)`"
        if line.count("](") != len(markdown.LINK.findall(line)):
            yield number, "a link that is not understood: no brackets, blanks or titles in the target"


def link_problems(root, files):
    """Links and pictures that lead nowhere; how many were looked at is in `looked`."""
    folders = {posixpath.join(*name.split("/")[:count]) for name in files for count in range(1, name.count("/") + 1)}
    anchors = {}
    for page in [*pages_of(files), *sorted(name for name in files if OTHERS.fullmatch(name))]:
        text = read(root, page)
        for number, problem in not_understood(text):
            yield f"{page}:{number}: {problem}"
        for number, is_picture, words, target in markdown.links(text):
            if markdown.is_outside(target):
                if is_picture:
                    yield f"{page}:{number}: the picture `{target}` would be fetched"
                continue
            to, anchor = markdown.resolved(page, target)
            if is_picture and (to not in files or not words.strip()):
                yield f"{page}:{number}: the picture `{target}` is not there, or has no words for whoever does not see it"
            elif not target or to not in files and to not in folders:
                yield f"{page}:{number}: `{target}` leads to no file of the repository"
            elif anchor and not to.endswith(".md"):
                yield f"{page}:{number}: `{target}`: only pages have anchors"
            elif anchor:
                if to not in anchors:
                    anchors[to] = markdown.anchors(read(root, to))
                if anchor not in anchors[to]:
                    yield f"{page}:{number}: `{target}`: no heading of {to} is called so"


class Page(html.parser.HTMLParser):
    """What a page of the book leads to and what leads to it."""

    # What a browser fetches or goes to.
    ATTRIBUTES = {"href", "src", "srcset", "poster", "data", "action"}

    def __init__(self, text):
        super().__init__()
        self.anchors, self.targets = set(), []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("id", "name"):
                self.anchors.add(value)
            if name in self.ATTRIBUTES and value is not None:
                self.targets.append((self.getpos()[0], tag, name, value))


def book_problems(book, pages):
    """What is wrong with a built book that has to have these pages."""
    found = {str(path.relative_to(book)): Page(path.read_text(encoding="utf-8")) for path in sorted(book.rglob("*.html"))}
    for page in pages:
        if page not in found:
            yield f"{page}: is not in the book"
    for name, page in found.items():
        # Served in the place of any page that is not there, so that its links begin at the root of the server.
        if name == "404.html":
            continue
        for line, tag, attribute, target in page.targets:
            if markdown.is_outside(target):
                if tag != "a" and not target.startswith("data:"):
                    yield f"{name}:{line}: <{tag} {attribute}> would be fetched: `{target}`"
                continue
            path, _, anchor = urllib.parse.unquote(target).partition("#")
            to = posixpath.normpath(posixpath.join(posixpath.dirname(name), path)) if path else name
            if to.startswith("../") or not (book / to).is_file():
                yield f"{name}:{line}: `{target}` leads to nothing in the book"
            elif anchor and to.endswith(".html") and anchor not in found[to].anchors:
                yield f"{name}:{line}: `{target}`: nothing of {to} is called so"


def tried(files, work):
    """What is said of a folder with these files."""
    with tempfile.TemporaryDirectory(prefix="pages-") as folder:
        root = pathlib.Path(folder)
        for name, text in files.items():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text(text, encoding="utf-8")
        return "\n".join(work(root))


def unrefused():
    """What of `pages_refusals.py` does not come out as it has to."""

    def pages(files):
        return tried(files, lambda root: [*summary_problems(root, set(files)), *link_problems(root, set(files))])

    def book(files):
        return tried(files, lambda root: book_problems(root, ["index.html"]))

    for work, refused, passed in ((pages, pages_refusals.PAGES_REFUSED, pages_refusals.PAGES_PASSED), (book, pages_refusals.BOOKS_REFUSED, pages_refusals.BOOKS_PASSED)):
        for files, words in refused:
            problem = work(files)
            if words not in problem:
                yield f"pages_refusals.py: {files!r} should be refused with {words!r}, and comes to {problem!r}"
        for files in passed:
            problem = work(files)
            if problem:
                yield f"pages_refusals.py: {files!r} should pass, and comes to {problem!r}"


def main(arguments):
    wrong = list(unrefused())
    files = tracked(ROOT)
    pages = pages_of(files)
    if arguments == ["pages"]:
        wrong.extend([*summary_problems(ROOT, files), *link_problems(ROOT, files)])
        what = f"{len(pages)} pages of the book and {sum(1 for name in files if OTHERS.fullmatch(name))} others"
    elif arguments[:1] == ["book"] and len(arguments) == 2:
        book = pathlib.Path(arguments[1])
        wrong.extend(book_problems(book, [f"{posixpath.relpath(page, DOCS)[:-3]}.html" for page in pages]))
        what = f"{sum(1 for _ in book.rglob('*.html'))} pages of the built book"
    else:
        print("usage: docs/tests/pages_check.py pages|book FOLDER", file=sys.stderr)
        return 2
    for problem in wrong:
        print(f"error: {problem}", file=sys.stderr)
    print(f"{'failed' if wrong else 'passed'}: links of {what}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
