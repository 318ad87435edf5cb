//! A run that every worker makes first: a machine on which numbers come out otherwise is found by it.

use std::sync::Arc;

use sha2::{Digest, Sha256};

use super::error::ShardError;
use crate::project::Project;
use crate::run::{Job, JobPlace, MeasuredMetrics, StoredRun, Wanted};
use files::{Memory, hexadecimal};
use results::Requests;
use scenario::registry::Registry;

/// People who decide by noise and transcendental functions or walk by a plan, before vehicles that brake and that do not.
const ENCOUNTERS: &str = "\
scenario mind {
  road { lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra { width: 4 m } }
  vehicle av { start 45 m before crossing; speed 40 km/h; controller carla_behavior }
  pedestrian walker { model commotions; start 2 m from kerb; appears at 0.5 s }
  repeat 2
  expect { no collision }
}
scenario kinematics {
  road { lanes forward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra { width: 4 m } }
  vehicle av { start 60 m before crossing; speed 47 km/h; controller constant_speed }
  pedestrian walker { model scripted; start 2 m from kerb; appears at 1 s }
  pedestrian other { model carla_walker; start 3 m from kerb; appears at 2 s }
  expect { no collision }
}
";

/// SHA-256 (hexadecimal) of all that came of the runs.
///
/// # Errors
/// If the registry lacks what ships, or a run of it fails.
pub fn canary(registry: &Registry) -> Result<String, ShardError> {
    let broken = |message: String| ShardError::Canary { message };
    let files = Memory::default().with("canary.scn", ENCOUNTERS);
    let project =
        Project::open("canary.scn", registry, &files).map_err(|problems| broken(problems.to_string()))?;
    let measured = MeasuredMetrics::new(Requests::defaults(registry));
    let mut hash = Sha256::new();
    for trial in project.suites()[0].plan.trials() {
        for case in trial.cases.iter() {
            let (place, measured) = (JobPlace::default(), Arc::clone(&measured));
            let wanted = Wanted::Outcome;
            let done = Job { place, case, measured, wanted, alone: false, change: None }.run();
            if let Err(failure) = &done.result {
                return Err(broken(format!("{failure:?}")));
            }
            hash.update(StoredRun::of(wanted, &done.result).to_bytes());
        }
    }
    Ok(hexadecimal(&hash.finalize()))
}
