/* Brakes for whoever is near: cc -O2 -I.. brake.c -o brake */
#include "scenario_runner_av.h"

#define RUNS 64

static double braking_distance[RUNS];

static const char *start(const sr_run *run) {
    braking_distance[run->slot] = sr_number(run->parameters, "braking_distance");
    return NULL;
}

static const char *step(int slot, const sr_seen *seen, double *acceleration, double *mode) {
    int near = 0;
    for (int index = 0; index < seen->pedestrians; index++) {
        const sr_other *one = &seen->pedestrian[index];
        near |= 0 < one->x && one->x < braking_distance[slot] && fabs(one->y) < 4;
    }
    int brakes = near && seen->speed > 0;
    *mode = brakes;
    *acceleration = brakes ? -3.0 : 0.5 * (seen->cruise_speed - seen->speed);
    return NULL;
}

int main(int argc, char **argv) {
    static const sr_controller brake = {
        "brake", "1", "acceleration", RUNS, "\"cruise\",\"brake\"", SR_NUMBER(braking_distance, "m", 25, 1, 60), start, step, NULL, NULL,
    };
    return sr_serve(&brake, argc, argv);
}
