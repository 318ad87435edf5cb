"""What pages of Markdown hold: their links, pictures and the anchors of their headings, outside of blocks."""

import html
import posixpath
import re

FENCE = re.compile(r"(`{3,}|~{3,})")
# The target ends at a bracket; those that ship have none, nor blanks or titles.
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\[\]]*\])*)\]\(([^()\s]*)\)")
CODE = re.compile(r"(`+)(?!`).*?(?<!`)\1(?!`)")
OUTSIDE = re.compile(r"[a-z][a-z0-9+.-]*:", re.IGNORECASE)


def prose(text):
    """The lines with their numbers, those of fenced blocks left out."""
    fence = None
    for number, line in enumerate(text.splitlines(), 1):
        found = FENCE.match(line.lstrip())
        if fence is None and found:
            fence = found[1]
        elif fence is not None:
            if found and line.strip() == found[1] and found[1].startswith(fence):
                fence = None
        else:
            yield number, line


def without_code(line):
    """The line with what stands in backquotes blanked, which keeps columns."""
    return CODE.sub(lambda code: " " * len(code[0]), line)


def links(text):
    """Every link and picture: line, whether it is a picture, its text, its target."""
    for number, line in prose(text):
        # The text of a link may have code in it, its target has none.
        hidden = CODE.sub(lambda code: "\0" * len(code[0]), line)
        for match in LINK.finditer(hidden):
            yield number, match[1] == "!", line[match.start(2) : match.end(2)], match[3]


def slug(heading):
    """The anchor of a heading, as GitHub and mdBook make it."""
    text = re.sub(LINK, lambda link: link[2], heading).replace("`", "").strip().lower()
    return "".join("-" if c == " " else c for c in html.unescape(text) if c.isalnum() or c in " -_")


def anchors(text):
    """The anchors of a page's headings; of equal ones the second ends in `-1`."""
    seen, found = {}, set()
    for _, line in prose(text):
        heading = re.match(r"#{1,6}\s+(.*?)\s*#*$", line)
        if heading:
            name = slug(heading[1])
            count = seen.get(name, 0)
            seen[name] = count + 1
            found.add(f"{name}-{count}" if count else name)
    return found


def is_outside(target):
    return bool(OUTSIDE.match(target)) or target.startswith("//")


def resolved(page, target):
    """The path in the repository that a link of a page leads to, and the anchor there."""
    path, _, anchor = target.partition("#")
    if not path:
        return page, anchor
    return posixpath.normpath(posixpath.join(posixpath.dirname(page), path)), anchor
