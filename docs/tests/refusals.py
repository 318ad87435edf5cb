"""Pages that `blocks` has to refuse, each with words of what is said of it: how a page could be green without being right.

`blocks` tries them before all pages, and some that have to pass beside them.
"""

RUN = "```sh\necho a\n```\n"
SAID = "```text\na\n```\n"

REFUSED = [
    # Nothing is run.
    ("```sh network\necho a\n```\n", "no block of this page is run"),
    # A marker or a language that is misspelt.
    ("```sh exit=100\nfalse\n```\n", "`exit=100` is not known"),
    ("```sh exits=0\ntrue\n```\n", "`exits=0` is not known"),
    ("```sh netwrok\ntrue\n```\n", "`netwrok` is not known"),
    (RUN + "```sh exits=1 network\nfalse\n```\n", "one word"),
    (RUN + "```text shown network\na\n```\n", "one word"),
    (RUN + "```sh shown\nfalse\n```\n", "`shown` is not known"),
    (RUN + "```csv slow\na\n```\n", "nothing stands after `csv`"),
    (RUN + "```lua edtior\na\n```\n", "nothing stands after `lua`"),
    ("```sh slow\nfalse\n```\n", "no block of this page is run"),
    ("```text shown\na\n```\n", "no block of this page is run"),
    # A block that is not run, of a command that is none.
    (RUN + "```sh data\nscenario-runner calibrate --no-such-option\n```\n", "is not understood"),
    (RUN + "```sh toolchain\ncd a\nscenario-runner clibrate x --outt y | tail\n```\n", "is not understood"),
    (RUN + "```bash\nfalse\n```\n", "`bash` is neither"),
    (RUN + "```\nfalse\n```\n", "without a language"),
    (RUN + "```text exits=1\na\n```\n", "nothing stands after `text`"),
    (RUN + "```text slow\na\n```\n", "nothing stands after `text`"),
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
    ("```sh slow\necho a\n```\n" + RUN + "```text\nb\n```\n", "is not what is printed"),
    # What is said of blocks.
    (RUN + "<!-- blocks: nothing -->\n", "what is said of blocks"),
    ("<!--blocks: in a copy of suites -->\n<!-- blocks : x -->\n" + RUN, "what is said of blocks"),
    ("<!-- blocks: in a copy of no_such_folder -->\n" + RUN, "no path of the repository"),
    ("<!-- blocks: in a copy of ../a -->\n" + RUN, "no path of the repository"),
    ("<!-- blocks: a.scn is what stands in blocks without a name -->\n" + RUN, "no block is a part"),
    ("<!-- blocks: a.scn is what stands in blocks without a name -->\n" + RUN + "```scn\nlet a = 1 m\n```\n```scn\nlet a = 2 x\n```\n", "`a.scn` is wrong"),
    (RUN + "```scn\nlet a = 1 m\n```\n", "a file without a name"),
    # Parts of scenarios.
    ("```scn in vehicle\ncontroller no_such\n```\n", "`part_1.scn` is wrong"),
    ("```scn in vehicle\ncontroller yielding\n}\n```\n", "`part_1.scn` is wrong"),
    ("```scn in suite\nseed 1\n```\n", "a part has no name"),
    ("```scn in\nseed 1\n```\n", "a part has no name"),
    ("```scn in scenario vehicle\nseed 1\n```\n", "a part has no name"),
    ("```suite in vehicle\nspeed 1 m/s\n```\n", "nothing stands after `suite`"),
    (RUN + "```sh data\nscenario-runner calibrate --count 5 > b.svg\n```\n![a](a.svg)\n", "is not the picture"),
    # Files and pictures.
    ("`a.scn`:\n```scn\nlet a = \n```\n" + RUN, "`a.scn` is wrong"),
    ("`a.suite`:\n```suite\nsuite a { scenarios \"b.scn\" }\n```\n" + RUN, "`a.suite` is wrong"),
    (RUN + "`a.scn`:\n```scn\nlet a = \n```\n", "`a.scn` is wrong"),
    ("`a.scn`:\n```scn\nlet a = \n```\n" + RUN + "`a.scn`:\n```scn\nlet a = 1 m\n```\n", "`a.scn` is wrong"),
    ("`a.json`:\n```json\n{,}\n```\n" + RUN, "`a.json` is wrong"),
    ("`a.toml`:\n```toml\na\n```\n" + RUN, "`a.toml` is wrong"),
    ("`a.py`:\n```python\na b\n```\n" + RUN, "`a.py` is wrong"),
    ("`a.csv`:\n```csv\na,b\n1\n```\n" + RUN, "`a.csv` is wrong"),
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
    RUN + "```sh slow\nfalse\n```\n" + SAID + "```text shown\na\n```\n```lua editor\na\n```\n",
    RUN + "```sh data\nscenario-runner calibrate --count 5 > x\n```\n",
    RUN + "```sh data\nscenario-runner calibrate --count 5 > a.svg\n```\n![a](a.svg)\n",
    "# Only words.\n",
    "```scn in pedestrian\nmodel scripted { speed: 1 m/s }\n```\n",
    "<!-- blocks: in a copy of scenarios suites -->\n```sh\nls suites/zebra.suite >suites/a\n```\n",
    "<!-- blocks: b/a.scn is what stands in blocks without a name -->\n```scn\nlet a = 1 m\n```\n```sh\ncat b/a.scn\n```\n```text\nlet a = 1 m\nlet b = a\n```\n```scn\nlet b = a\n```\n",
]
