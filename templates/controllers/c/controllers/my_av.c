/* The controller under test: cc -O2 -o my_av my_av.c */
#include "scenario_runner_av.h"

#define RUNS 64

/* What is kept of a run stands at its slot. */
static double gap[RUNS];

static const char *start(const sr_run *run) {
    gap[run->slot] = sr_number(run->parameters, "gap");
    return NULL;
}

static const char *step(int slot, const sr_seen *seen, double *acceleration, double *mode) {
    /* x is ahead of the vehicle's centre, y to the left of the middle of its lane. */
    double needed = 0;
    for (int index = 0; index < seen->pedestrians; index++) {
        const sr_other *one = &seen->pedestrian[index];
        if (one->x > 0 && fabs(one->y) < 4) {
            double room = one->x - seen->length / 2 - gap[slot];
            double braking = seen->speed * seen->speed / (2 * (room > 0.1 ? room : 0.1));
            needed = braking > needed ? braking : needed;
        }
    }
    *mode = needed > 1;
    *acceleration = needed > 1 ? -(needed < 6 ? needed : 6) : 0.5 * (seen->cruise_speed - seen->speed);
    return NULL;
}

int main(int argc, char **argv) {
    static const sr_controller my_av = {
        "my_av", "1", "acceleration", RUNS, "\"cruise\",\"brake\"", SR_NUMBER(gap, "m", 3, 1, 10), start, step, NULL, NULL,
    };
    return sr_serve(&my_av, argc, argv);
}
