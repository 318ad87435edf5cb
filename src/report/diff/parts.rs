//! Where two runs part, in words.

use super::sides::RunDiff;
use crate::format::with_unit;
use crate::replay::describe;
use crate::wording::ending_words;
use results::{PartedIn, Parting, PartsBy};
use scenario::{Dimension, significant};
use sim::Command;

/// So many things that differ at one moment are told.
const DIFFERENCES: usize = 4;

/// Where they part: in bits, then by what can be seen; each with the moment that it is about, s.
pub fn partings(run: &RunDiff) -> Vec<(String, Option<f64>)> {
    let two = run.two;
    let end = with_unit(two.a.outcome.ending.time, Dimension::TIME);
    let is_cut = two.a.outcome.cut_off.is_some() && two.b.outcome.cut_off.is_some();
    let cut = if is_cut { ". Both are cut off: what would have come was not seen" } else { "" };
    let Some(first) = &two.first else {
        let why = match two.differs.is_empty() {
            true => ", since nothing that this run is made of depends on what is otherwise",
            false => "; what differs changes nothing in this run",
        };
        let said = format!("they do not part: the same bit for bit until both end at {end}{why}{cut}");
        return vec![(said, None)];
    };
    let parting = format!("they part at {:.3} s: {}", first.time, by(first));
    match &two.apart {
        Some(apart) if apart.time == first.time => {
            vec![(format!("{parting}; at once by more than 0.1 m or 0.1 m/s"), Some(first.time))]
        }
        Some(apart) => {
            let seen = format!("by more than 0.1 m or 0.1 m/s at {:.3} s: {}", apart.time, by(apart));
            vec![(parting, Some(first.time)), (seen, Some(apart.time))]
        }
        None => {
            let never = format!("never by more than 0.1 m or 0.1 m/s until both end at {end}{cut}");
            vec![(parting, Some(first.time)), (never, None)]
        }
    }
}

/// What differs at the moment at which they part.
pub fn by(parting: &Parting) -> String {
    if parting.by.is_empty() {
        return "in bits, between the moments that both have".to_string();
    }
    let mut said: Vec<String> = parting.by.iter().take(DIFFERENCES).map(parted).collect();
    if parting.by.len() > DIFFERENCES {
        said.push(format!("{} more", parting.by.len() - DIFFERENCES));
    }
    said.join("; ")
}

fn parted(PartsBy { who, what }: &PartsBy) -> String {
    match what {
        PartedIn::Presence { in_a } => format!("{who} is there in {} only", if *in_a { "A" } else { "B" }),
        PartedIn::Motion { apart, relative_speed, a, b } => {
            let speed = |value: f64| with_unit(value, Dimension::SPEED);
            let apart = match (*apart > 0.0, *relative_speed > 0.0) {
                (true, _) => format!("is {} apart", with_unit(*apart, Dimension::LENGTH)),
                (false, true) => "is at one place".to_string(),
                (false, false) => "faces or accelerates otherwise at one place".to_string(),
            };
            match speed(*a) == speed(*b) {
                true => format!("{who} {apart}, with {} in both", speed(*a)),
                false => format!("{who} {apart}, with {} in A, {} in B", speed(*a), speed(*b)),
            }
        }
        PartedIn::Event { a: Some(a), b: Some(b) } => {
            format!("{who} {} in A, {} in B", describe(a), describe(b))
        }
        PartedIn::Event { a: Some(what), b: None } => format!("{who} {} in A only", describe(what)),
        PartedIn::Event { a: None, b: Some(what) } => format!("{who} {} in B only", describe(what)),
        PartedIn::Event { a: None, b: None } => String::new(),
        PartedIn::Decision { a, b } => {
            format!("{who} is told {} in A, {} in B", told(a.as_ref()), told(b.as_ref()))
        }
        PartedIn::Ending { a, b } if a.time == b.time => {
            format!("{} in A, {} in B", ending_words(a.reason), ending_words(b.reason))
        }
        PartedIn::Ending { a, b } => {
            let (letter, ending) = if a.time < b.time { ("A", a) } else { ("B", b) };
            format!("{letter} ends, {}, and the other goes on", ending_words(ending.reason))
        }
    }
}

/// A command: as many digits as tell near ones apart.
fn told(command: Option<&Command>) -> String {
    let number = |value: f64| significant(value, 6);
    match command {
        None => "nothing yet".to_string(),
        Some(Command::Acceleration(acceleration)) => format!("{} m/s^2", number(*acceleration)),
        Some(Command::Pedals { throttle, brake }) => {
            format!("throttle {} brake {}", number(*throttle), number(*brake))
        }
    }
}
