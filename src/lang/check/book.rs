//! How the numbers of a scenario were written, by name.

use std::collections::BTreeMap;

use super::places::TextPlaces;
use crate::source::Span;
use crate::value::Typed;
use scenario::Written;

/// What [`scenario::Scenario::written`] is made of.
#[derive(Debug, Default)]
pub struct Book(pub BTreeMap<String, Written>);

impl Book {
    /// A statement about a road user, under `av.speed`.
    pub fn statement(
        &mut self,
        road_user: &str,
        statement: &str,
        typed: Option<&Typed>,
        places: &TextPlaces,
    ) {
        if let Some(typed) = typed {
            self.shifted(road_user, statement, typed, 0.0, places);
        }
    }

    /// As [`Self::statement`]; what the scenario has is `offset` more than what was written.
    pub fn shifted(
        &mut self,
        road_user: &str,
        statement: &str,
        typed: &Typed,
        offset: f64,
        places: &TextPlaces,
    ) {
        self.add(format!("{road_user}.{statement}"), typed, offset, places);
    }

    /// A statement that has no number, under `av.signals`.
    pub fn said(&mut self, road_user: &str, statement: &str, span: Span, places: &TextPlaces) {
        let written = Written { notation: None, origin: places.origin(span), offset: 0.0 };
        self.0.insert(format!("{road_user}.{statement}"), written);
    }

    /// Settings of a part of a road user, under `av.controller.braking_distance`.
    pub fn settings(
        &mut self,
        road_user: &str,
        part: &str,
        settings: &[(String, Typed)],
        places: &TextPlaces,
    ) {
        for (name, typed) in settings {
            self.add(format!("{road_user}.{part}.{name}"), typed, 0.0, places);
        }
    }

    /// A variation, under its name.
    pub fn variation(&mut self, name: &str, typed: &Typed, places: &TextPlaces) {
        self.add(name.to_string(), typed, 0.0, places);
    }

    fn add(&mut self, name: String, typed: &Typed, offset: f64, places: &TextPlaces) {
        let (notation, origin) = (typed.notation, places.origin(typed.span));
        self.0.insert(name, Written { notation, origin, offset });
    }
}
