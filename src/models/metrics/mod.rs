//! Metrics: numbers read off a run while it happens, one file a family, and a list of them.
//!
//! To add one: make a [`Metric`] in the file of its family (or a new file) and list it in [`metrics`]. Events inside
//! a step are interpolated linearly; a metric that does not exist in a run is `None`, never a magic number.

#[cfg(test)]
mod bends;
mod braking;
mod conflict;
mod contact;
mod crossing;
#[cfg(test)]
mod fixture;
mod gaps;
#[cfg(test)]
mod gaps_tests;
mod headway;
mod jerk;
mod kerb;
mod lateral;
mod people;
mod proximity;
mod signal;
#[cfg(test)]
mod tests;
mod travel;
mod vehicles;

use scenario::Metric;

/// The metrics that ship, in the order of reports.
pub fn metrics() -> Vec<Metric> {
    vec![
        contact::collision(),
        contact::impact_speed(),
        contact::impact_point(),
        conflict::pet(),
        conflict::pet_area(),
        conflict::passed_first(),
        conflict::gap_accepted(),
        conflict::tta_at_entry(),
        proximity::min_ttc(),
        contact::min_distance(),
        proximity::drac(),
        headway::time_headway(),
        braking::max_deceleration(),
        braking::sudden_speed_change(),
        jerk::max_jerk(),
        jerk::rms_jerk(),
        lateral::lateral_acceleration(),
        kerb::kerb_contact(),
        signal::ran_red(),
        travel::time_lost(),
        travel::travel_time(),
        travel::stopped_time(),
        crossing::crossing_initiation_time(),
        crossing::crossing_duration(),
        crossing::pedestrian_delay(),
        gaps::gap_taken(),
        gaps::gaps_missed(),
        gaps::entry_after_previous(),
        gaps::time_left_on_leaving(),
        gaps::step_back(),
        people::plausibility(),
        vehicles::vehicle_pet(),
        vehicles::entered_first(),
        vehicles::vehicle_ttc(),
        vehicles::vehicle_distance(),
    ]
}
