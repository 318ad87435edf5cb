//! Panics, which are bugs of ours: what was said, where in the source, and in which run.

use std::any::Any;
use std::cell::RefCell;
use std::fmt::{self, Display, Formatter};
use std::panic::{self, AssertUnwindSafe, catch_unwind, resume_unwind};

use serde::{Deserialize, Serialize};

/// A panic, with what is needed to find the bug.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Panicked {
    /// The key of the run in which it happened, if in one.
    pub case: Option<String>,
    /// What was said.
    pub message: String,
    /// File, line and column of the source, where [`note_places`] was called before.
    pub place: Option<String>,
}

thread_local! {
    /// Where this thread panicked last.
    static PLACE: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// From now on panics are noted with their place instead of being printed; with `RUST_BACKTRACE` they are printed, too.
pub fn note_places() {
    let print = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        let place = info.location().map(ToString::to_string);
        // A thread that is being torn down has nowhere to note it.
        let _ = PLACE.try_with(|noted| *noted.borrow_mut() = place);
        if std::env::var_os("RUST_BACKTRACE").is_some_and(|value| value != "0") {
            print(info);
        }
    }));
}

impl Panicked {
    /// What a caught panic carried.
    pub fn of(payload: Box<dyn Any + Send>) -> Self {
        let payload = match payload.downcast::<Self>() {
            Ok(known) => return *known,
            Err(other) => other,
        };
        let text = payload.downcast_ref::<&str>().map(|text| text.to_string());
        let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
        Self {
            case: None,
            message: text.unwrap_or_else(|| "without a message".to_string()),
            place: PLACE.with(|noted| noted.borrow_mut().take()),
        }
    }

    /// What `work` gives, or the panic that ended it.
    pub fn catch<T>(work: impl FnOnce() -> T) -> Result<T, Self> {
        catch_unwind(AssertUnwindSafe(work)).map_err(Self::of)
    }
}

/// Runs what belongs to the run called `case`: a panic in it goes on with that name, to whichever thread it gets.
pub fn in_case<T>(case: &str, work: impl FnOnce() -> T) -> T {
    Panicked::catch(work).unwrap_or_else(|panicked| {
        let case = panicked.case.clone().unwrap_or_else(|| case.to_string());
        resume_unwind(Box::new(Panicked { case: Some(case), ..panicked }))
    })
}

impl Display for Panicked {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        if let Some(case) = &self.case {
            write!(out, "{case}: ")?;
        }
        write!(out, "scenario-runner {} panicked", env!("CARGO_PKG_VERSION"))?;
        if let Some(place) = &self.place {
            write!(out, " at {place}")?;
        }
        write!(out, ": {}; this is a bug of scenario-runner, please report it", self.message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_keeps_the_run_that_it_happened_in_and_what_was_said() {
        let inside = Panicked::catch(|| in_case("a/b/rep=1", || panic!("{} is no number", "x"))).unwrap_err();
        assert_eq!(inside.case.as_deref(), Some("a/b/rep=1"));
        assert_eq!(inside.message, "x is no number");
        // The innermost run is the one.
        let twice = Panicked::catch(|| in_case("outer", || in_case("inner", || panic!("said")))).unwrap_err();
        assert_eq!((twice.case.as_deref(), twice.message.as_str()), (Some("inner"), "said"));
        let outside = Panicked::catch(|| std::panic::panic_any(5)).unwrap_err();
        assert_eq!((outside.case, outside.message.as_str()), (None, "without a message"));
        assert_eq!(Panicked::catch(|| in_case("a", || 7)), Ok(7));
    }

    #[test]
    fn it_crosses_threads() {
        let join = std::thread::spawn(|| in_case("a/b/rep=2", || panic!("there")));
        let panicked = Panicked::of(join.join().unwrap_err());
        assert_eq!(panicked.case.as_deref(), Some("a/b/rep=2"));
        let text = panicked.to_string();
        assert!(
            text.starts_with("a/b/rep=2: scenario-runner ") && text.contains(env!("CARGO_PKG_VERSION")),
            "{text}"
        );
        assert!(text.ends_with("there; this is a bug of scenario-runner, please report it"), "{text}");
    }
}
