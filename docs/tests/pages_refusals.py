"""Pages and books that `pages_check.py` has to refuse, each with words of what is said of it, and some that have to pass."""

SUMMARY = {"docs/SUMMARY.md": "# Summary\n\n- [A](a.md)\n"}
PAGE = {"docs/a.md": "# A\n"}


def page(text, **more):
    return {**SUMMARY, "docs/a.md": text, **more}


PAGES_REFUSED = [
    # Of the summary.
    ({**PAGE}, "is not there"),
    ({**SUMMARY, **PAGE, "docs/b.md": "# B\n"}, "docs/b.md: is not in"),
    ({**SUMMARY, **PAGE, "docs/deep/b.md": "# B\n"}, "docs/deep/b.md: is not in"),
    ({**SUMMARY}, "`a.md` is no page"),
    ({"docs/SUMMARY.md": "- [A](a.md)\n- [B]()\n", **PAGE}, "`` is no page"),
    ({"docs/SUMMARY.md": "- [A](a.md)\n- [A](./a.md)\n", **PAGE}, "is there twice"),
    ({"docs/SUMMARY.md": "- [A](a.md)\n- [A](a.md#a)\n", **PAGE}, "is no page"),
    ({"docs/SUMMARY.md": "- `[A](a.md)`\n", **PAGE}, "docs/a.md: is not in"),
    ({"docs/SUMMARY.md": "```text\n- [A](a.md)\n```\n", **PAGE}, "docs/a.md: is not in"),
    # Links that lead nowhere.
    (page("[b](b.md)"), "leads to no file"),
    (page("[b]()"), "leads to no file"),
    (page("[b\nc](b.md)"), "not understood"),
    (page("[b](A.md)"), "leads to no file"),
    (page("[b](../b.md)"), "leads to no file"),
    (page("[b](../../b.md)"), "leads to no file"),
    (page("[b](/docs/a.md)"), "leads to no file"),
    (page("[`b`](b.md)"), "leads to no file"),
    (page("[a [b]](b.md)"), "leads to no file"),
    (page("| [b](b.md) |"), "leads to no file"),
    (page("# [b](b.md)"), "leads to no file"),
    (page("```text\na\n```\n[b](b.md)"), "leads to no file"),
    (page("```text\na\n```\n[b](b.md)\n```text\na\n```\n"), "leads to no file"),
    (page("`a` [b](b.md) `c`"), "leads to no file"),
    (page("[x](http://127.0.0.1/) [b](b.md)"), "leads to no file"),
    # Anchors that are not there.
    (page("# A\n[b](#b)"), "no heading of docs/a.md"),
    (page("# A\n```text\n# B\n```\n[b](#b)"), "no heading of docs/a.md"),
    (page("# A\n[b](#a-1)"), "no heading of docs/a.md"),
    (page("# A\n[b](a.md#A)"), "no heading of docs/a.md"),
    (page("# A\n[b](../b.md#b)", **{"b.md": "# C\n"}), "no heading of b.md"),
    (page("# A\n[b](../b.txt#b)", **{"b.txt": "# b\n"}), "only pages"),
    ({**SUMMARY, **PAGE, "b.md": "[a](docs/a.md#b)"}, "b.md:1"),
    # Pictures.
    (page("![b](b.svg)"), "the picture `b.svg` is not there"),
    (page("![](b.svg)", **{"docs/b.svg": "<svg/>"}), "has no words"),
    (page("![b](https://127.0.0.1/b.svg)"), "would be fetched"),
    # What is not looked at.
    (page("[b]\n\n[b]: b.md\n"), "by reference"),
    (page('<a href="b.md">b</a>'), "in HTML"),
    (page('<IMG src="b.svg">'), "in HTML"),
    (page("[b](<b.md>)[b](b c.md)"), "not understood"),
    (page('[b](a.md "title")'), "not understood"),
]

PAGES_PASSED = [
    {**SUMMARY, **PAGE},
    page("# A\n## A\n### `b_c`: d, *e*\n[a](#a) [a](#a-1) [a](#b_c-d-e) [a](a.md#a)"),
    page("[b](../b) [c](../b/c.txt) ![d](d.svg)", **{"b/c.txt": "", "docs/d.svg": "<svg/>"}),
    page("`[b](b.md)`\n```text\n[b](b.md) <a>\n```\n"),
    {**SUMMARY, **PAGE, "templates/b.md": "[c](c.md)", "docs/tests/b.md": "[c](c.md)"},
]

BOOKS_REFUSED = [
    ({"a.html": ""}, "index.html: is not in the book"),
    ({"index.html": '<a href="a.html">a</a>'}, "leads to nothing"),
    ({"index.html": '<a href="a.md">a</a>'}, "leads to nothing"),
    ({"index.html": '<a href="../a.html">a</a>'}, "leads to nothing"),
    ({"index.html": '<a href="a/index.html">a</a>', "a/index.html": '<a href="a.html">a</a>'}, "a/index.html:1"),
    ({"index.html": '<img src="a.svg">'}, "leads to nothing"),
    ({"index.html": '<script src="a.js"></script>'}, "leads to nothing"),
    ({"index.html": '<a href="#a">a</a>'}, "is called so"),
    ({"index.html": '<a href="a.html#a">a</a>', "a.html": '<p id="b">'}, "is called so"),
    ({"index.html": '<img src="https://127.0.0.1/a.svg">'}, "would be fetched"),
    ({"index.html": '<link href="//127.0.0.1/a.css">'}, "would be fetched"),
]

BOOKS_PASSED = [
    {"index.html": '<p id="a"><a href="#a">a</a><a href="b/c.html#d">a</a><a href="https://127.0.0.1/">a</a>', "b/c.html": '<p id="d"><a href="../index.html">a</a>'},
    {"index.html": "", "404.html": '<a href="/a.html">a</a>'},
]
