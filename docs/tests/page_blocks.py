"""The blocks of a page: what they are, whether they can be understood, and how what is printed is compared. `blocks` runs them."""

import pathlib
import re

# Why a block is not run, and what is said of those that are not. `slow` ones are with `--slow`.
KINDS = {
    "network": "need a network",
    "editor": "need an editor",
    "terminal": "need somebody at a terminal",
    "toolchain": "need a compiler and the sources",
    "data": "need data that are not in the repository",
    "slow": "take long",
    "shown": "only show something",
}
# Of the files of these languages their endings.
FILE_LANGUAGES = {
    "scn": ("scn",),
    "suite": ("suite",),
    "yaml": ("yaml", "yml"),
    "json": ("json",),
    "csv": ("csv",),
    "toml": ("toml",),
    "python": ("py",),
    "rust": ("rs",),
    "lua": ("lua",),
    "elisp": ("el",),
}
# What a part of a scenario is put into to be checked, in the place of the dots.
SURROUNDINGS = {
    "scenario": "scenario part { road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }\n…\npedestrian walker { model scripted; start 2 m from kerb; appears when time_to_arrival(av) = 6 s }\nexpect { no collision } }\n",
    "vehicle": "scenario part { road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }\nvehicle av { speed 30 km/h; start 60 m before crossing\n…\n}\n"
    "pedestrian walker { model scripted; start 2 m from kerb }\nexpect { no collision } }\n",
    "pedestrian": "scenario part { road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }\nvehicle av { controller yielding; speed 30 km/h; start 60 m before crossing }\n"
    "pedestrian walker { start 2 m from kerb\n…\n}\nexpect { no collision } }\n",
}
# What a page says of its blocks, in a comment.
SAID = re.compile(r"<!-- blocks: (.*) -->")
COPY = re.compile(r"in a copy of ([a-z_ ./]+)")
JOINED = re.compile(r"([a-z_/]+\.scn) is what stands in blocks without a name")

class Wrong(Exception):
    """Something about a page: its line and what is wrong there."""

    def __init__(self, line, text):
        super().__init__(text)
        self.line = line


class Block:
    def __init__(self, line, info, name):
        self.line, self.info, self.name, self.lines = line, info, name, []

    @property
    def language(self):
        return self.info[0]

    @property
    def surrounded(self):
        """A part of a scenario with what it is a part of."""
        return SURROUNDINGS[self.info[2]].replace("…", self.text) if self.info[1:2] == ["in"] else None

    @property
    def is_part(self):
        """Whether it is a part of the one file that the page says."""
        return self.info == ["scn"] and not self.name

    @property
    def text(self):
        return "".join(self.lines)

    @property
    def kind(self):
        """Why it is not run, if it is not."""
        return next((word for word in self.info[1:] if word in KINDS), None)


class Page:
    """The blocks of a page, and what it says of them."""

    def __init__(self, text):
        self.copies, self.joined = [], None
        self.blocks = blocks_of(text)
        for number, line in enumerate(text.splitlines(), 1):
            if re.search(r"<!--\s*blocks", line):
                self.say(number, line)
        parts = [block for block in self.blocks if block.is_part]
        if self.joined and not parts:
            raise Wrong(1, f"no block is a part of `{self.joined}`")
        checked(self.blocks, self.joined)
        self.whole = "".join(block.text for block in parts)

    def say(self, number, line):
        said = SAID.fullmatch(line)
        copy, joined = said and COPY.fullmatch(said[1]), said and JOINED.fullmatch(said[1])
        if copy:
            self.copies.extend(copy[1].split())
        elif joined and self.joined is None:
            self.joined = joined[1]
        else:
            raise Wrong(number, "what is said of blocks is `in a copy of PATH …`, or, once, `FILE.scn is what stands in blocks without a name`")


def blocks_of(page):
    """The blocks of a page's text. A block that could be overlooked is an error."""
    blocks, block, before = [], None, ""
    for number, line in enumerate(page.splitlines(keepends=True), 1):
        fence = re.match(r"```(?!`)(.*)", line)
        if block is None and not fence and re.search(r"```|~~~|<pre", line):
            raise Wrong(number, "a block begins with three backquotes at the start of a line")
        if block is None and fence:
            info = fence[1].split()
            if not info:
                raise Wrong(number, "a block without a language: `sh`, `text`, or that of a file")
            named = re.search(r"`([^`]+)`:$", before.strip())
            block = Block(number, info, named and named[1])
        elif block is not None and line.rstrip() == "```":
            blocks.append(block)
            block, before = None, ""
        elif block is not None and fence:
            raise Wrong(number, f"a block within the block of line {block.line}")
        elif block is not None:
            block.lines.append(line)
        elif line.startswith(("    ", "\t")):
            raise Wrong(number, "an indented block, which nothing runs: put it between backquotes")
        else:
            before = line
    if block is not None:
        raise Wrong(block.line, "a block that does not end")
    return blocks


def checked(blocks, joined):
    """Refuses what would be run or compared otherwise than its writer meant, or not at all."""
    if blocks and not any(block.info[1:2] == ["in"] or block.language == "sh" and not block.kind for block in blocks):
        raise Wrong(1, "no block of this page is run")
    printed = None
    for block in blocks:
        if not block.text.strip():
            raise Wrong(block.line, "an empty block")
        if len(block.info) > 2 and block.info[1] != "in":
            raise Wrong(block.line, f"one word after `{block.language}` at most")
        if block.language == "sh":
            check_commands(block)
        elif block.language == "text":
            check_output(block, printed)
        else:
            check_file(block, joined)
        if block.name and block.language in ("sh", "text"):
            raise Wrong(block.line, f"`{block.name}` would be written if this were a block of a file")
        printed = block


def check_commands(block):
    for word in block.info[1:]:
        if word not in KINDS and not re.fullmatch(r"exits=[1-9][0-9]*", word) or word == "shown":
            raise Wrong(block.line, f"`{word}` is not known of `sh`: `exits=100` (not 0), {kinds(KINDS.keys() - {'shown'})}")
    if block.info[1:] and not block.kind and len(commands_of(block.text)) != 1:
        raise Wrong(block.line, "an exit code is that of one command, and here is not one")


def check_output(block, printed):
    if block.info[1:] == ["shown"]:
        return
    if block.info[1:]:
        raise Wrong(block.line, "nothing stands after `text` but `shown`")
    if printed is None or printed.language != "sh":
        raise Wrong(block.line, "an output without a `sh` block before it")
    if printed.kind not in (None, "slow"):
        raise Wrong(block.line, "an output of a block that is not run")
    if not block.text.replace("…", "").strip():
        raise Wrong(block.line, "an output that compares nothing")


def check_file(block, joined):
    if block.language not in FILE_LANGUAGES:
        raise Wrong(block.line, f"`{block.language}` is neither `sh` nor `text` nor of a file ({', '.join(FILE_LANGUAGES)})")
    if block.info[:2] == ["scn", "in"]:
        if len(block.info) != 3 or block.info[2] not in SURROUNDINGS or block.name:
            raise Wrong(block.line, f"a part has no name, and is `scn in` {kinds(SURROUNDINGS)}")
        return
    if block.info[1:] and block.info[1] not in ("editor", "toolchain"):
        raise Wrong(block.line, f"nothing stands after `{block.language}` but `editor` or `toolchain`")
    if block.kind or block.is_part and joined:
        return
    if not block.name:
        raise Wrong(block.line, "a file without a name: the line before it is, say, `crossing.scn`:")
    if pathlib.PurePosixPath(block.name).is_absolute() or ".." in pathlib.PurePosixPath(block.name).parts:
        raise Wrong(block.line, f"`{block.name}` is not below the folder of the page")
    if block.name.rsplit(".", 1)[-1] not in FILE_LANGUAGES[block.language]:
        raise Wrong(block.line, f"`{block.name}` is not of `{block.language}`")


def kinds(words):
    return ", ".join(f"`{word}`" for word in sorted(words))


def commands_of(text):
    """The commands of a block of `sh` or a file of a CI server, without comments and with what goes on in the next line joined."""
    joined = re.sub(r"\\\n\s*", " ", text)
    lines = (re.sub(r"(^|\s+)#.*", "", line).strip() for line in joined.splitlines())
    return [" ".join(line.split()) for line in lines if line]


def pattern_of(expected):
    """A regular expression for an output in which `…` stands for what is left out."""
    parts = []
    for line in normalised(expected).splitlines():
        if line.strip() == "…":
            parts.append(r"(?:[^\n]*\n)*?")
        else:
            parts.append("[^\n]*".join(re.escape(piece) for piece in line.split("…")) + "\n")
    return re.compile("".join(parts))


def normalised(text):
    """Without durations and without blanks at ends of lines and of the text."""
    text = re.sub(r"\[ *[0-9]+\.[0-9]+s\]", "[duration]", text)
    lines = [line.rstrip() for line in text.splitlines()]
    return "\n".join(lines).strip("\n") + "\n"


def difference(expected, actual):
    """The first line that was expected and does not come, in the order of the lines."""
    lines = normalised(expected).splitlines()
    for count in range(1, len(lines) + 1):
        if not pattern_of("\n".join(lines[:count]) + "\n…\n").fullmatch(normalised(actual)):
            return f"does not come (or not there): {lines[count - 1]!r}"
    return "more comes than is shown"
