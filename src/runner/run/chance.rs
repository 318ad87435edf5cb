//! Whether chance plays a part in a world: a property of what is built, not of how runs happened to go.

use crate::plan::Cases;
use scenario::{Chance, ModelSetup, World};

/// What can draw from the run's random streams, such as "`walker` (`carla_walker`)". Where nothing can, every run is the
/// same, whatever its seed. Vehicle dynamics cannot: they are not given a stream.
pub fn drawing(world: &World) -> Vec<String> {
    let mut all = Vec::new();
    for one in &world.vehicles {
        all.extend(note(&one.name, &one.controller, |model| model.chance));
        all.extend(one.sees.as_ref().and_then(|sees| note(&one.name, sees, |model| model.chance)));
    }
    for one in &world.pedestrians {
        all.extend(note(&one.name, &one.model, |model| model.chance));
    }
    all
}

/// Whether chance plays no part in any of these runs: neither do they draw anything, nor does anything in their worlds.
pub fn nothing_is_drawn(cases: &Cases) -> bool {
    !cases.are_drawn() && cases.worlds().iter().all(|world| drawing(world).is_empty())
}

/// What to say of a model if it can draw. Of a mere name nothing is known, and it cannot be run.
fn note<T>(who: &str, setup: &ModelSetup<T>, chance: impl Fn(&T) -> Chance) -> Option<String> {
    let draws = setup.model.entry().is_none_or(|model| chance(model).possible(&setup.settings));
    draws.then(|| format!("`{who}` (`{}`)", setup.model))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::plan;
    use crate::run::{FreeFlows, Unwatched, run_case};
    use files::Disk;
    use models::standard;
    use results::Requests;

    /// Who may draw in a meeting of the two, and whether its runs under three seeds are the same; `None` if they cannot
    /// meet.
    fn meeting(vehicle: &str, model: &str) -> Option<(Vec<String>, bool)> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("meeting.scn");
        let text = format!(
            "scenario meeting {{
  road {{ lane_width 4 m; speed_limit 30 km/h; crossing zebra }}
  vehicle av {{ controller {vehicle}; speed 30 km/h; start 60 m before crossing }}
  pedestrian walker {{ model {model}; start 3 m from kerb; appears at 1 s }}
  horizon 14 s
  repeat 3
}}
"
        );
        std::fs::write(&path, text).unwrap();
        let suite = lang::load(&path, &standard(), &Disk).ok()?.suite;
        let plan = plan(&suite).ok()?;
        let cases: Vec<_> = plan.trial(0).cases.iter().collect();
        let run = |case| {
            run_case(case, &Requests::defaults(&standard()), &FreeFlows::default(), &mut Unwatched).ok()
        };
        let runs: Vec<_> = cases.iter().map(run).collect::<Option<_>>()?;
        let same = runs.windows(2).all(|pair| pair[0].fingerprint == pair[1].fingerprint);
        Some((drawing(&cases[0].world), same))
    }

    #[test]
    fn what_cannot_draw_is_the_same_under_every_seed() {
        let registry = standard();
        let controllers = registry.controllers().names().map(|name| (name, "scripted"));
        let people = registry.pedestrians().names().map(|name| ("carla_behavior", name));
        let mut certain = 0;
        for (vehicle, model) in controllers.chain(people) {
            let Some((draws, same)) = meeting(vehicle, model) else { continue };
            if draws.is_empty() {
                assert!(same, "{vehicle} and {model} draw something");
                certain += 1;
            }
        }
        assert!(certain >= 5, "{certain}");
    }

    #[test]
    fn who_draws_is_named() {
        let (draws, same) = meeting("carla_behavior; sees { position_noise: 0.5 m }", "scripted").unwrap();
        assert_eq!((draws, same), (vec!["`av` (`sees`)".to_string()], false));
        let (draws, same) = meeting("carla_behavior; sees { range: 40 m }", "scripted").unwrap();
        assert_eq!((draws, same), (Vec::new(), true));
        let (draws, _) = meeting("carla_behavior", "commotions").unwrap();
        assert_eq!(draws, ["`walker` (`commotions`)"]);
    }
}
