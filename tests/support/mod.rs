//! What the tests share: the place of the data they share with others, and a zebra to walk over.
#![allow(dead_code, reason = "every test uses what it needs")]

pub mod counting;
pub mod generated;
pub mod program;
pub mod street;
pub mod text;
pub mod zebra;
