//! What property tests of every target are given: text as people and enemies write it.

use proptest::prelude::*;

/// Pieces that mean something to one target or another.
const PIECES: [&str; 46] = [
    "\u{1b}[31m",
    "\u{1b}]0;title\u{7}",
    "\u{1b}[2J",
    "\u{9b}1A",
    "\u{8}",
    "\0",
    "\u{7f}",
    "\r",
    "\n",
    "\r\n",
    "\t",
    "\u{202e}",
    "\u{2066}",
    "\u{2028}",
    "\u{feff}",
    "\u{fffe}",
    "\u{ffff}",
    "\u{fdd0}",
    "\u{e0041}",
    "<script>alert(1)</script>",
    "</script>",
    "]]>",
    "<!--",
    "&amp;",
    "&#0;",
    "\"",
    "'",
    "::error::",
    "%0A",
    "::",
    ",",
    ":",
    "# SKIP",
    "\\",
    "ok 1 - ",
    "...",
    "---",
    "|",
    "`",
    "~~~~",
    "```",
    "@everyone",
    "![x](y)",
    "=cmd|' /C calc'!A0",
    "+1",
    "-1",
];

/// Any text, most of it made of pieces that mean something to somebody.
pub fn text() -> impl Strategy<Value = String> {
    let piece = prop_oneof![
        4 => proptest::sample::select(&PIECES[..]).prop_map(str::to_string),
        1 => proptest::sample::select(&["@A1", "=1+1", " =1", "\t=1", "ﬀ", "日本", "e\u{301}"][..]).prop_map(str::to_string),
        2 => any::<char>().prop_map(String::from),
        2 => "[a-z ]{0,4}",
    ];
    proptest::collection::vec(piece, 0..8).prop_map(|pieces| pieces.concat())
}
