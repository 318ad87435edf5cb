//! Typed views of the nodes of a tree: what each kind of node is made of, as the grammar says.
//!
//! A view is a node whose kind is known. Its methods are the node's parts; those that the grammar always has are there without asking.
//! `every` goes through all views of a kind below a node, in the order of the text: every expression, every name, every quantity.

/// Declares views. A part is written `name: View` if it is always there, `(View)` if it may be missing, `[View]` if there may be
/// any number of it, and `{keyword}` for whether a keyword is there.
macro_rules! views {
    ($($(#[$doc:meta])* $view:ident = $($rule:ident)|+ { $($part:ident: $what:tt),* $(,)? })*) => {
        $(
            $(#[$doc])*
            #[derive(Debug, Clone, Copy)]
            pub struct $view<'t>(Node<'t>);

            impl<'t> View<'t> for $view<'t> {
                fn cast(node: Node<'t>) -> Option<Self> {
                    Self::is(node.rule()).then_some(Self(node))
                }

                fn is(rule: Rule) -> bool {
                    matches!(rule, $(Rule::$rule)|+)
                }
            }

            impl<'t> std::ops::Deref for $view<'t> {
                type Target = Node<'t>;

                fn deref(&self) -> &Node<'t> {
                    &self.0
                }
            }

            impl<'t> $view<'t> {
                $(views!(@method $part $what);)*
            }
        )*

        #[cfg(test)]
        pub(super) const MADE: &[Made] = &[$(Made {
            view: stringify!($view),
            rules: &[$(Rule::$rule),+],
            parts: &[$((stringify!($part), views!(@part $what))),*],
        }),*];
    };
    (@method $part:ident ($view:ident)) => {
        pub fn $part(self) -> Option<$view<'t>> {
            self.0.part()
        }
    };
    (@method $part:ident [$view:ident]) => {
        pub fn $part(self) -> impl Iterator<Item = $view<'t>> {
            self.0.parts()
        }
    };
    (@method $part:ident {$word:ident}) => {
        pub fn $part(self) -> bool {
            self.0.has(Rule::$word)
        }
    };
    (@method $part:ident $view:ident) => {
        pub fn $part(self) -> $view<'t> {
            self.0.whole()
        }
    };
    (@part ($view:ident)) => { Holds::Perhaps(stringify!($view)) };
    (@part [$view:ident]) => { Holds::Any(stringify!($view)) };
    (@part {$word:ident}) => { Holds::Word(Rule::$word) };
    (@part $view:ident) => { Holds::Always(stringify!($view)) };
}

/// Declares views of nodes that are of one of several kinds.
macro_rules! choices {
    ($($(#[$doc:meta])* $choice:ident = $($view:ident)|+;)*) => {
        $(
            $(#[$doc])*
            #[derive(Debug, Clone, Copy)]
            pub enum $choice<'t> {
                $($view($view<'t>)),+
            }

            impl<'t> View<'t> for $choice<'t> {
                fn cast(node: Node<'t>) -> Option<Self> {
                    $(if let Some(view) = $view::cast(node) {
                        return Some(Self::$view(view));
                    })+
                    None
                }

                fn is(rule: Rule) -> bool {
                    $($view::is(rule))||+
                }
            }

            impl<'t> std::ops::Deref for $choice<'t> {
                type Target = Node<'t>;

                fn deref(&self) -> &Node<'t> {
                    match self {
                        $(Self::$view(view) => view),+
                    }
                }
            }
        )*

        #[cfg(test)]
        pub(super) const CHOICES: &[(&str, &[&str])] =
            &[$((stringify!($choice), &[$(stringify!($view)),+])),*];
    };
}

mod common;
mod criterion;
mod experiment;
mod file;
mod kinds;
mod program;
mod rating;
mod road_user;
mod scenario;
mod suite;
#[cfg(test)]
mod tests;
mod value;

pub use common::*;
pub use criterion::*;
pub use experiment::*;
pub use file::*;
pub use kinds::*;
pub use program::*;
pub use rating::*;
pub use road_user::*;
pub use scenario::*;
pub use suite::*;
pub use value::*;

use super::tree::{Node, Rule};

/// A node whose kind is known.
pub trait View<'t>: Copy + std::ops::Deref<Target = Node<'t>> {
    /// The node as this, if it is of that kind.
    fn cast(node: Node<'t>) -> Option<Self>;

    /// Whether nodes of that rule are of that kind.
    #[doc(hidden)]
    fn is(rule: Rule) -> bool;
}

impl<'t> Node<'t> {
    /// Every view of that kind, the node itself and what is below it, in the order of the text.
    pub fn every<V: View<'t>>(self) -> impl Iterator<Item = V> {
        self.descendants().filter_map(V::cast)
    }

    /// The node's own parts of that kind.
    pub fn parts<V: View<'t>>(self) -> impl Iterator<Item = V> {
        self.children().filter_map(V::cast)
    }

    /// The first of the node's own parts of that kind.
    fn part<V: View<'t>>(self) -> Option<V> {
        self.children().find_map(V::cast)
    }

    /// The part that the grammar gives every node of this kind, which a test holds.
    fn whole<V: View<'t>>(self) -> V {
        self.part().expect("the grammar gives it this part")
    }

    fn has(self, rule: Rule) -> bool {
        self.children().any(|child| child.rule() == rule)
    }
}

/// What a view says that it is made of, for the test against the grammar.
#[cfg(test)]
struct Made {
    view: &'static str,
    rules: &'static [Rule],
    parts: &'static [(&'static str, Holds)],
}

#[cfg(test)]
#[derive(Debug, Clone, Copy, PartialEq)]
enum Holds {
    Always(&'static str),
    Perhaps(&'static str),
    Any(&'static str),
    Word(Rule),
}
