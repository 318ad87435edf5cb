"""Pages that `blocks` has to refuse, each with words of what is said of it: how a page could be green without being right.

`blocks` tries them before all pages, and some that have to pass beside them.
"""

RUN = "```sh\necho a\n```\n"
SAID = "```text\na\n```\n"

REFUSED = [
    # Nothing is run.
    ("# A page\n", "no block of this page is run"),
    ("```sh network\necho a\n```\n", "no block of this page is run"),
    # A marker or a language that is misspelt.
    ("```sh exit=100\nfalse\n```\n", "`exit=100` is not known"),
    ("```sh exits=0\ntrue\n```\n", "`exits=0` is not known"),
    ("```sh netwrok\ntrue\n```\n", "`netwrok` is not known"),
    (RUN + "```sh exits=1 network\nfalse\n```\n", "one word"),
    (RUN + "```bash\nfalse\n```\n", "`bash` is neither"),
    (RUN + "```\nfalse\n```\n", "without a language"),
    (RUN + "```text exits=1\na\n```\n", "nothing stands after `text`"),
    (RUN + "```sh\n```\n", "an empty block"),
    # A block that nothing would see.
    (RUN + "\n    false\n", "an indented block"),
    (RUN + "~~~sh\nfalse\n~~~\n", "three backquotes"),
    (RUN + "- a\n\n  ```sh\n  false\n  ```\n", "three backquotes"),
    (RUN + "> ```sh\n> false\n> ```\n", "three backquotes"),
    (RUN + "````sh\nfalse\n````\n", "three backquotes"),
    (RUN + "<pre>\nfalse\n</pre>\n", "three backquotes"),
    ("```sh\ntrue\n", "does not end"),
    ("```sh\ntrue\n```text\na\n```\n", "a block within the block"),
    # Commands that end otherwise than is said.
    ("```sh\nfalse\n```\n", "ends with exit code 1, not 0"),
    ("```sh\nfalse | cat\n```\n", "ends with exit code 1, not 0"),
    ("```sh\nfalse\ntrue\n```\n", "ends with exit code 1, not 0"),
    ("```sh\necho $unset\n```\n", "ends with exit code 1, not 0"),
    ("```sh exits=100\ntrue\n```\n", "ends with exit code 0, not 100"),
    ("```sh exits=100\nfalse\n```\n", "ends with exit code 1, not 100"),
    ("```sh exits=1\nfalse\ntrue\n```\n", "of one command"),
    # Outputs that nothing printed, or that say nothing.
    (SAID + RUN, "without a `sh` block"),
    (RUN + SAID + SAID, "without a `sh` block"),
    (RUN + "`a.csv`:\n```csv\na\n```\n" + SAID, "without a `sh` block"),
    (RUN + "```sh editor\necho a\n```\n" + SAID, "a block that is not run"),
    (RUN + "```text\n…\n```\n", "compares nothing"),
    (RUN + "```text\nb\n```\n", "is not what is printed"),
    (RUN + "```text\na\nb\n```\n", "is not what is printed"),
    (RUN + "```text\na…b\n```\n", "is not what is printed"),
    ("```sh\necho a; echo b\n```\n" + SAID, "more comes"),
    ("```sh\necho a; echo b\n```\n```text\n…\nb\n…\na\n…\n```\n", "is not what is printed"),
    ("```sh\necho ab\n```\n" + SAID, "is not what is printed"),
    # Files and pictures.
    (RUN + "```csv\na\n```\n", "a file without a name"),
    (RUN + "`a.csv`:\n\n```csv\na\n```\n", "a file without a name"),
    (RUN + "`../a.csv`:\n```csv\na\n```\n", "not below the folder"),
    (RUN + "`a.scn`:\n```csv\na\n```\n", "is not of `csv`"),
    ("`a.scn`:\n```sh\ntrue\n```\n", "would be written"),
    (RUN + "![a](a.svg)\n", "is not the picture"),
]

PASSED = [
    RUN + SAID,
    "```sh exits=3\nexit \\\n  3\n```\n",
    "`a/b.csv`:\n```csv\na\n```\n```sh\ncat a/b.csv\n```\n" + SAID,
    "```sh\necho '[   0.002s] b'; echo c; echo d >&2\n```\n```text\n[  12.345s] …\n…\nd\n```\n",
    RUN + "```sh network\nfalse\n```\n```sh editor\nfalse\n```\n",
]
