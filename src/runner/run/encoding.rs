//! Jobs, and what came of them, as bytes: for executors that make runs in another process or on another machine.
//!
//! The bytes are MessagePack with names of fields: it carries every number to its last bit, infinite ones and those that are
//! none included, and programs in any language read it. What a world or a request names is written as that name, and whoever
//! reads it has a registry that knows it.
//!
//! They begin with their layout and with the version of the program: what another layout or version wrote is refused by name, since
//! a run is a pure function of its case for one version alone.

use std::fmt;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::job::{Done, Job, MeasuredMetrics};
use super::messagepack::{Reader, read_last, to_messagepack};
use scenario::registry::{Registry, UnknownEntry};

/// Why bytes are no job, or nothing that came of one.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum DecodingError {
    /// They are other bytes, or not all of them.
    #[error("these bytes are no {what}: {message}")]
    Malformed {
        /// What they should be, such as `job`.
        what: &'static str,
        /// In the words of the decoder.
        message: String,
    },
    /// Whoever wrote them is not the program that reads them.
    #[error("these bytes are a {what} of {found}, and this is {here}")]
    OtherProgram {
        /// What they are, such as `job`.
        what: &'static str,
        /// Who wrote them.
        found: EncodedBy,
        /// Who reads them.
        here: EncodedBy,
    },
    /// Whoever wrote them has entries that whoever reads them lacks.
    #[error(transparent)]
    Unknown(#[from] UnknownEntry),
}

/// Who wrote bytes, which stands at their beginning.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct EncodedBy {
    /// Of the bytes, whatever the program; a change of what they hold makes it one larger.
    pub layout: u32,
    /// Of the program.
    pub version: String,
}

impl EncodedBy {
    /// The layout of these bytes.
    const LAYOUT: u32 = 3;

    /// This program.
    pub fn here() -> Self {
        Self { layout: Self::LAYOUT, version: env!("CARGO_PKG_VERSION").to_string() }
    }
}

impl fmt::Display for EncodedBy {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "scenario-runner {} (layout {})", self.version, self.layout)
    }
}

impl Job {
    /// The job as MessagePack.
    pub fn to_bytes(&self) -> Vec<u8> {
        encoded(self)
    }

    /// What [`Self::to_bytes`] wrote, ready to be run.
    ///
    /// # Errors
    /// If the bytes are no job, or name what the registry does not have.
    pub fn from_bytes(bytes: &[u8], registry: &Registry) -> Result<Self, DecodingError> {
        Ok(decoded::<Self>("job", bytes)?.resolved(registry)?)
    }

    /// The same, with everything that it names resolved: of one that was read, only the names are known.
    ///
    /// # Errors
    /// The first name that the registry does not have.
    pub fn resolved(self, registry: &Registry) -> Result<Self, UnknownEntry> {
        let Self { place, case, measured, wanted, alone, change } = self;
        let requests = measured.requests.clone().resolved(registry)?;
        let case = case.resolved(registry)?;
        Ok(Self { place, case, measured: MeasuredMetrics::new(requests), wanted, alone, change })
    }
}

impl Done {
    /// What came of the job, as MessagePack.
    pub fn to_bytes(&self) -> Vec<u8> {
        encoded(self)
    }

    /// What [`Self::to_bytes`] wrote.
    ///
    /// # Errors
    /// If the bytes are nothing that came of a job, or name what the registry does not have.
    pub fn from_bytes(bytes: &[u8], registry: &Registry) -> Result<Self, DecodingError> {
        Ok(decoded::<Self>("result of a job", bytes)?.resolved(registry)?)
    }

    /// The same, with everything that its case names resolved: of one that was read, only the names are known.
    ///
    /// # Errors
    /// The first name that the registry does not have.
    pub fn resolved(self, registry: &Registry) -> Result<Self, UnknownEntry> {
        let Self { place, case, result } = self;
        Ok(Self { place, case: case.resolved(registry)?, result })
    }
}

fn encoded(data: &impl Serialize) -> Vec<u8> {
    let mut bytes = to_messagepack(&EncodedBy::here());
    bytes.extend(to_messagepack(data));
    bytes
}

fn decoded<T: DeserializeOwned>(what: &'static str, bytes: &[u8]) -> Result<T, DecodingError> {
    let malformed = |message: String| DecodingError::Malformed { what, message };
    let mut reader = Reader::from_read_ref(bytes);
    let found = EncodedBy::deserialize(&mut reader).map_err(|error| malformed(error.to_string()))?;
    let here = EncodedBy::here();
    if found != here {
        return Err(DecodingError::OtherProgram { what, found, here });
    }
    read_last(&mut reader).map_err(malformed)
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::{Arc, LazyLock};

    use proptest::prelude::*;

    use super::*;
    use crate::plan::plan;
    use crate::run::{JobFailure, JobPlace, Panicked, Ran, RunError, Wanted};
    use files::Disk;
    use models::standard;
    use results::Requests;
    use scenario::registry::EntryKind;
    use scenario::{Case, Dimension, ModelSetup, Reference, Settings, Suite, Value, VehicleSetup};
    use sim::{ControllerError, ModelError, Stated, StatedBy};

    fn suite(file: &str) -> Suite {
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join(file);
        lang::load(&path, &standard(), &Disk).unwrap_or_else(|_| panic!("{file} is a suite")).suite
    }

    /// The first run of every trial of a suite, with all metrics.
    fn jobs(file: &str, wanted: Wanted) -> Vec<Job> {
        let suite = suite(file);
        let mut requests = Requests::defaults(&standard());
        suite.scenarios.iter().for_each(|scenario| requests.include(&scenario.criteria));
        let measured = MeasuredMetrics::new(requests);
        let job = |case| Job {
            place: JobPlace { sequence: 3, run: 1 << 60 },
            case,
            measured: measured.clone(),
            wanted,
            alone: false,
            change: None,
        };
        plan(&suite).unwrap().trials().map(|trial| job(trial.cases.first())).collect()
    }

    fn job() -> Job {
        static FIRST: LazyLock<Job> =
            LazyLock::new(|| jobs("suites/zebra_unsafe.suite", Wanted::Outcome).remove(0));
        FIRST.clone()
    }

    /// What came of it, without what depends on the clock.
    fn timeless(mut done: Done) -> Done {
        if let Ok(ran) = &mut done.result {
            ran.outcome.wall_time = Default::default();
        }
        done
    }

    #[test]
    fn a_job_that_was_read_back_comes_to_the_same() {
        let files = ["suites/zebra.suite", "suites/zebra_unsafe.suite", "suites/matrix.suite"];
        for (file, wanted) in files.into_iter().zip([Wanted::Outcome, Wanted::Trace, Wanted::TraceAndEvents])
        {
            for job in jobs(file, wanted).into_iter().take(25) {
                let read = Job::from_bytes(&job.to_bytes(), &standard()).unwrap();
                assert_eq!(read, job);
                let (here, there) = (timeless(job.run()), timeless(read.run()));
                assert_eq!(here, there);
                let ran = here.result.as_ref().expect("shipped suites run");
                assert_eq!(ran.trace.samples.is_empty(), wanted == Wanted::Outcome);
                assert_eq!(ran.events.is_empty(), wanted != Wanted::TraceAndEvents);
                assert_eq!(Done::from_bytes(&here.to_bytes(), &standard()).unwrap(), here);
            }
        }
    }

    /// Numbers that others would round, leave out or take for another.
    fn number() -> impl Strategy<Value = f64> {
        let odd = [f64::INFINITY, f64::NEG_INFINITY, f64::NAN, -0.0, f64::MIN_POSITIVE / 2.0, 0.1 + 0.2];
        prop_oneof![any::<u64>().prop_map(f64::from_bits), prop::sample::select(odd.to_vec())]
    }

    proptest! {
        #[test]
        fn every_number_survives(
            seed: u64, step in number(), setting in number(), metric in prop::option::of(number()), place in number()
        ) {
            let mut job = job();
            job.case.seed = seed;
            let world = Arc::make_mut(&mut job.case.world);
            world.step = step;
            world.vehicles[0].controller.settings.set("number", Value::Number(setting));
            let read = Job::from_bytes(&job.to_bytes(), &standard()).unwrap();
            let world = &read.case.world;
            prop_assert_eq!((read.case.seed, world.step.to_bits()), (seed, step.to_bits()));
            let found = world.vehicles[0].controller.settings.number("number");
            prop_assert_eq!(found.to_bits(), setting.to_bits());

            let mut done = Job { wanted: Wanted::Trace, ..self::job() }.run();
            let Ok(Ran { outcome, trace, .. }) = &mut done.result else { panic!("it runs") };
            outcome.fingerprint = seed;
            outcome.metrics[0] = metric;
            trace.samples[0].position.x = place;
            let Ok(Ran { outcome, trace, .. }) = Done::from_bytes(&done.to_bytes(), &standard()).unwrap().result else {
                panic!("it ran")
            };
            prop_assert_eq!(outcome.fingerprint, seed);
            prop_assert_eq!(outcome.metrics[0].map(f64::to_bits), metric.map(f64::to_bits));
            prop_assert_eq!(trace.samples[0].position.x.to_bits(), place.to_bits());
        }
    }

    #[test]
    fn every_failure_says_the_same_when_it_was_read_back() {
        let suite = suite("suites/zebra_unsafe.suite");
        let stated = |of| Stated { value: 0.5, dimension: Dimension::SPEED, of };
        let setting = StatedBy::Setting("speed".into());
        let numbers = [stated(setting), stated(StatedBy::Start), stated(StatedBy::Step)];
        let failures = [
            JobFailure::Error(RunError::Unknown { kind: EntryKind::VehicleDynamics, name: "hover".into() }),
            JobFailure::Error(RunError::Model {
                who: "av".into(),
                error: ModelError::stating("{} is above {} and {}", numbers, "less"),
            }),
            JobFailure::Error(RunError::Controller {
                who: "av".into(),
                time: -f64::MIN_POSITIVE,
                free_flow: true,
                error: ControllerError::with_hint("lane is None", "give it a map"),
            }),
            JobFailure::Error(RunError::NoEncounter {
                message: "at 10 s `b` appears inside `a`".into(),
                hint: "elsewhere".into(),
                begun: true,
            }),
            JobFailure::Panicked(Panicked {
                case: Some("a/b".into()),
                message: "no \u{1f6b2}".into(),
                place: None,
            }),
        ];
        for failure in failures {
            let done = Done { place: JobPlace::default(), case: job().case, result: Err(failure) };
            let read = Done::from_bytes(&done.to_bytes(), &standard()).unwrap();
            assert_eq!(read, done);
            if let (Err(JobFailure::Error(here)), Err(JobFailure::Error(there))) = (done.result, read.result)
            {
                let told = |error: &RunError| error.told(&suite.scenarios[0]);
                assert_eq!((told(&here), here.hint()), (told(&there), there.hint()));
            }
        }
    }

    #[test]
    fn what_no_registry_has_is_refused() {
        type RunChange = fn(&mut Case);
        let unknown =
            |kind, name: &str| Err(DecodingError::Unknown(UnknownEntry { kind, name: name.into() }));
        let refused = |change: RunChange| {
            let mut job = job();
            change(&mut job.case);
            Job::from_bytes(&job.to_bytes(), &standard()).map(|_| ())
        };
        let names: [(EntryKind, RunChange); 3] = [
            (EntryKind::Controller, |case| vehicle(case).controller.model = Reference::unresolved("gone")),
            (EntryKind::VehicleDynamics, |case| vehicle(case).dynamics.model = Reference::unresolved("gone")),
            (EntryKind::PedestrianModel, |case| {
                Arc::make_mut(&mut case.world).pedestrians[0].model.model = Reference::unresolved("gone");
            }),
        ];
        for (kind, change) in names {
            assert_eq!(refused(change), unknown(kind, "gone"));
        }
        let sees = |case: &mut Case| {
            let model = Reference::unresolved("gone");
            vehicle(case).sees = Some(ModelSetup { model, settings: Settings::default() });
        };
        assert_eq!(refused(sees), unknown(EntryKind::Perception, "gone"));
        let mut job = job();
        let mut requests = job.measured.requests.clone();
        requests.iter_mut().next().expect("there are metrics").metric = Reference::unresolved("gone");
        job.measured = MeasuredMetrics::new(requests);
        let read = Job::from_bytes(&job.to_bytes(), &standard()).map(|_| ());
        assert_eq!(read, unknown(EntryKind::Metric, "gone"));
        assert_eq!(read.unwrap_err().to_string(), "there is no metric called `gone`");
    }

    fn vehicle(case: &mut Case) -> &mut VehicleSetup {
        &mut Arc::make_mut(&mut case.world).vehicles[0]
    }

    #[test]
    fn other_bytes_are_refused() {
        let bytes = job().to_bytes();
        let read = |bytes: &[u8]| Job::from_bytes(bytes, &standard()).map(|_| ()).unwrap_err().to_string();
        for length in [0, 1, bytes.len() / 2, bytes.len() - 1] {
            assert!(read(&bytes[..length]).starts_with("these bytes are no job: "));
        }
        let twice = [bytes.as_slice(), &bytes[..]].concat();
        assert_eq!(read(&twice), "these bytes are no job: more bytes follow it");
        assert!(Done::from_bytes(&bytes, &standard()).is_err());
    }

    /// What it means for a run, nobody knows of another version; so it is refused before anything else of it is read.
    #[test]
    fn what_another_program_wrote_is_refused_by_name() {
        let here = EncodedBy::here();
        let told = |writer: &EncodedBy, data: &[u8]| {
            let bytes = [&to_messagepack(writer), data].concat();
            Job::from_bytes(&bytes, &standard()).map(|_| ()).unwrap_err().to_string()
        };
        let job = to_messagepack(&job());
        let newer = EncodedBy { version: "77.0.0".into(), ..here.clone() };
        let wanted =
            format!("these bytes are a job of scenario-runner 77.0.0 (layout 3), and this is {here}");
        assert_eq!((told(&newer, &job), told(&newer, b"whatever")), (wanted.clone(), wanted));
        let laid_out = told(&EncodedBy { layout: 1, ..here.clone() }, &job);
        assert!(laid_out.contains(&format!("scenario-runner {} (layout 1)", here.version)), "{laid_out}");
        // What was written before that stood there.
        let read = Job::from_bytes(&job, &standard()).map(|_| ()).unwrap_err();
        assert!(matches!(read, DecodingError::Malformed { what: "job", .. }), "{read}");
        // A result of this program is no job of it either.
        let done = Done {
            place: JobPlace::default(),
            case: self::job().case,
            result: Err(JobFailure::Panicked(Panicked { case: None, message: "a".into(), place: None })),
        };
        assert!(matches!(
            Job::from_bytes(&done.to_bytes(), &standard()),
            Err(DecodingError::Malformed { .. })
        ));
        assert!(Done::from_bytes(&done.to_bytes(), &standard()).is_ok());
    }
}
