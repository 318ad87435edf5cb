//! Scenarios seen from above: what there is in the plane, drawn as SVG and as text, before a run and within one.
//!
//! Everything is a function of a world, and of what was recorded of its run: nothing here knows how runs are made.

mod facts;
mod moment;
mod outlook;
mod picture;
mod plane;
mod road;
mod sketch;
mod svg_sketch;
#[cfg(test)]
mod tests;
mod text_sketch;
mod view;

pub use picture::Sketch;
pub(crate) use plane::Mark;
pub(crate) use road::{beside, stop_lines, world_marks};
pub use sketch::AfterTheEnd;
pub(crate) use sketch::moment_text;
pub(crate) use view::view;
