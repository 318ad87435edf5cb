//! Whole runs through the library: models in their worlds, numerics, executors, and what does not matter.

mod along_bends;
mod autoware;
mod baselines;
mod bends;
mod calibrating;
mod carla;
mod commotions_world;
mod comparing;
mod course;
mod cyclists;
mod details;
mod diffing;
mod draws;
mod estimating;
mod executors;
mod following;
mod ground;
mod hiding;
mod jaywalker;
mod junctions;
mod keeping_clear;
mod left_hand;
mod looking;
mod meetings;
mod nothing_at_stake;
mod numerics;
mod otherwise;
mod perceived;
mod refuges;
mod same_as;
mod sequential_gates;
mod several_others;
mod signals;
mod steadiness;
mod steering;
mod stream_endings;
mod streams;
#[path = "../support/mod.rs"]
mod support;
mod values;

use support::counting::Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;
