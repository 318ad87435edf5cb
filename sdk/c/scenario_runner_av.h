/* Controllers of automated vehicles in C, tested by scenario-runner: C99 on POSIX, frames of doubles, no dependencies.
 *
 * Include it before anything else, in one file; examples/brake.c is a whole controller. Everything is in SI units: x ahead of the
 * vehicle's centre, y to the left of the middle of its lane, velocities over ground. What is not there is NAN. Numbers are read
 * by strtod: leave LC_NUMERIC alone. Standard output belongs to the runner: what is printed goes to the log. */
#ifndef SCENARIO_RUNNER_AV_H
#define SCENARIO_RUNNER_AV_H
#ifndef _POSIX_C_SOURCE
#define _POSIX_C_SOURCE 200809L
#endif
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* What somebody is. Who rides is among the pedestrians. */
#define SR_PEDESTRIAN 1.0
#define SR_CYCLIST 2.0
#define SR_ESCOOTER 3.0
#define SR_VEHICLE 4.0

/* Pedestrians, and vehicles (without accelerations). */
typedef struct { double id, x, y, vx, vy, ax, ay, length, width, kind; } sr_other;

/* How far ahead the curvature of the lane changes (m), and what it is there (1/m, to the left). */
typedef struct { double distance, curvature; } sr_change;

/* How far ahead the middle of a crossing is (m; negative behind), how wide, whether people have priority, and y of where they may wait. */
typedef struct { double distance, width, pedestrian_priority, right_edge, left_edge; } sr_crossing;

/* The scene of one decision; `time` in s, negative before the run begins; `signal` is 1 where vehicles have green, `amber` where they
 * have amber, and `stop_line` how far before the edge of the crossing they stop, all NAN without a signal. `travelled` is along
 * the lane from the middle of the crossing, `gradient` NAN on a road that says none; `lateral_offset` and `heading_error` (rad) are to
 * the left of the lane, 0 where nobody has steered. From `curvature` on the lane bends evenly from each
 * `change` to the next, and not at all behind the last, for 150 m; two at one distance are a jump. Every `crossing` is there, in the
 * order in which the vehicle comes to them (none from a runner older than that); what is said without a name is of the first ahead. */
typedef struct {
    double time, is_new, cruise_speed, distance_to_crossing, speed, acceleration, length, width, lane_width, speed_limit,
        crossing_width, pedestrian_priority, signal, right_kerb, left_kerb, travelled, curvature, gradient, amber, stop_line,
        lateral_offset, heading_error;
    int pedestrians, vehicles, changes, crossings;
    const sr_other *pedestrian, *vehicle;
    const sr_change *change;
    const sr_crossing *crossing;
} sr_seen;

/* A run that begins. `parameters` and `road` are JSON, to be read by sr_number, sr_flag, sr_text and sr_get. */
typedef struct { int slot; uint64_t seed; double step, cruise_speed, length, width; const char *parameters, *road; } sr_run;

typedef struct {
    const char *name, *version;
    const char *gives;      /* acceleration, pedals, speed or speed_plan: 1, 2, 1 or 32 doubles (pairs of s and m/s, then NAN) */
    int runs_at_once;       /* 1 .. 1024; what is kept of a run stands at its slot, below this */
    const char *modes;      /* JSON: "\"cruise\",\"brake\"" */
    const char *parameters; /* SR_NUMBER(gap, "m", 5, 1, 30) "," SR_FLAG(yields, true) */
    const char *(*start)(const sr_run *run);                                            /* NULL, or why it cannot */
    const char *(*step)(int slot, const sr_seen *seen, double *answer, double *mode);   /* the same; mode is an index */
    void (*finish)(int slot, const char *reason);
    double (*curvature)(int slot); /* of the way that the rear axle is to take, asked after each step: 1/m, to the left, NAN to keep
                                      the lane; NULL for who never steers */
} sr_controller;

#define SR_NUMBER(name, unit, value, low, high) \
    "{\"name\":\"" #name "\",\"unit\":\"" unit "\",\"default\":" #value ",\"low\":" #low ",\"high\":" #high "}"
#define SR_FLAG(name, value) "{\"name\":\"" #name "\",\"default\":" #value "}"
#define SR_WORD(name, value, options) "{\"name\":\"" #name "\",\"default\":\"" #value "\",\"options\":[" options "]}"
#define SR_TEXT(name, value) "{\"name\":\"" #name "\",\"default\":\"" value "\"}"

/* Just enough JSON: places in a text that is known to be right. */
static inline const char *sr_space(const char *at) { return at + strspn(at, " \t\r\n,:"); }

static inline const char *sr_skip(const char *at) { /* past a value */
    int depth = 0;
    do {
        at = sr_space(at);
        if (*at == '"') {
            for (at++; *at && *at != '"'; at++) at += *at == '\\' && at[1];
            at += *at == '"';
        } else if (*at == '{' || *at == '[') depth++, at++;
        else if (*at == '}' || *at == ']') depth--, at++;
        else at += strcspn(at, " \t\r\n,:{}[]\"");
    } while (depth > 0 && *at);
    return at;
}

/* The value of a key of an object, or NULL. */
static inline const char *sr_get(const char *object, const char *key) {
    size_t length = strlen(key);
    if (!object || *(object = sr_space(object)) != '{') return NULL;
    for (object = sr_space(object + 1); *object == '"'; object = sr_space(sr_skip(object))) {
        const char *name = object + 1, *end = sr_skip(object);
        object = sr_space(end);
        if ((size_t)(end - name) == length + 1 && !strncmp(name, key, length)) return object;
    }
    return NULL;
}

/* The first item of a list and the one after an item, or NULL. */
static inline const char *sr_item(const char *at) { return *(at = sr_space(at)) && *at != ']' ? at : NULL; }
static inline const char *sr_first(const char *list) { return list && *list == '[' ? sr_item(list + 1) : NULL; }
static inline const char *sr_next(const char *item) { return sr_item(sr_skip(item)); }

static inline double sr_number(const char *object, const char *key) {
    const char *value = sr_get(object, key);
    return value ? strtod(value, NULL) : NAN;
}
static inline int sr_flag(const char *object, const char *key) {
    const char *value = sr_get(object, key);
    return value && *value == 't';
}

/* A word or text of plain characters; 0 if there is none or no room for it. */
static inline int sr_text(const char *object, const char *key, char *into, size_t size) {
    const char *value = sr_get(object, key);
    size_t used = 0;
    if (!value || *value != '"') return 0;
    for (value++; *value && *value != '"' && used + 1 < size; into[used++] = *value++) value += *value == '\\';
    into[used] = 0;
    return *value == '"';
}

typedef struct { char *bytes; size_t used, room; } sr_buffer;

static inline void *sr_make_room(sr_buffer *buffer, size_t more) {
    if (buffer->used + more > buffer->room) {
        buffer->room = 2 * (buffer->used + more);
        buffer->bytes = (char *)realloc(buffer->bytes, buffer->room);
        if (!buffer->bytes) { fputs("out of memory\n", stderr); exit(1); }
    }
    buffer->used += more;
    return buffer->bytes + buffer->used - more;
}
static inline void sr_add(sr_buffer *buffer, const char *text) { memcpy(sr_make_room(buffer, strlen(text)), text, strlen(text)); }
static inline void sr_add_slot(sr_buffer *buffer, const char *before, int slot, const char *message) { /* {"slot":3,"message":"…"} */
    char text[48];
    snprintf(text, sizeof text, "%s{\"slot\":%d,\"message\":\"", before, slot);
    for (sr_add(buffer, text); *message; message++) {
        char one[3] = {'\\', *message, 0};
        sr_add(buffer, *message == '"' || *message == '\\' ? one : (one[1] = (unsigned char)*message < 32 ? ' ' : *message, one + 1));
    }
    sr_add(buffer, "\"}");
}

static inline void sr_send(sr_buffer *frame, FILE *out) {
    uint32_t length = (uint32_t)(frame->used - 4);
    memcpy(frame->bytes, &length, 4);
    if (fwrite(frame->bytes, 1, frame->used, out) != frame->used || fflush(out)) exit(1);
}
static inline void sr_begin(sr_buffer *frame) { frame->used = 0, memset(sr_make_room(frame, 8), 0, 8); }

/* Where the runner's columns are; whatever else it has is left out. */
static inline int sr_columns(const char *hello, const char *table, const char *names, int *places) {
    int count = 0, known = 0;
    for (const char *name = names; *name; name += strcspn(name, " "), name += *name == ' ') places[known++] = -1;
    for (const char *one = sr_first(sr_get(sr_get(hello, "columns"), table)); one; one = sr_next(one), count++) {
        size_t length = (size_t)(sr_skip(one) - one) - 2;
        int index = 0;
        for (const char *name = names; *name; name += strcspn(name, " "), name += *name == ' ', index++)
            if (strcspn(name, " ") == length && !strncmp(name, one + 1, length)) places[index] = count;
    }
    return count;
}
static inline void sr_pick(const double *row, const int *places, int count, double *into) {
    for (int index = 0; index < count; index++) into[index] = places[index] < 0 ? NAN : row[places[index]];
}

static inline void sr_open(const sr_controller *own, const char *open, sr_buffer *out, double *decided) {
    sr_buffer failed = {0, 0, 0};
    char number[24];
    int ready = 0;
    sr_begin(out);
    sr_add(out, "{\"ready\":[");
    for (const char *one = sr_first(open); one; one = sr_next(one)) {
        const char *car = sr_get(one, "vehicle"), *seed = sr_get(one, "seed");
        sr_run run = {(int)sr_number(one, "slot"), seed ? strtoull(seed, NULL, 10) : 0, sr_number(one, "step"),
                      sr_number(one, "cruise_speed"), sr_number(car, "length"), sr_number(car, "width"),
                      sr_get(one, "parameters"), sr_get(one, "road")};
        const char *wrong = own->start ? own->start(&run) : NULL;
        decided[run.slot] = NAN;
        snprintf(number, sizeof number, "%s%d", ready ? "," : "", run.slot);
        if (wrong) sr_add_slot(&failed, failed.used ? "," : "", run.slot, wrong);
        else sr_add(out, number), ready = 1;
    }
    if (failed.used) sr_add(out, "],\"failed\":["), memcpy(sr_make_room(out, failed.used), failed.bytes, failed.used);
    free(failed.bytes);
    sr_add(out, "]}");
}

/* Speaks with the runner until it says goodbye; the exit code of the program. `--runs-at-once=1` on the command line takes fewer. */
static inline int sr_serve(const sr_controller *own, int argc, char **argv) {
    FILE *in = fdopen(dup(0), "rb"), *out = fdopen(dup(1), "wb");
    sr_buffer request = {0, 0, 0}, answer = {0, 0, 0}, others = {0, 0, 0}, bends = {0, 0, 0}, zebras = {0, 0, 0}, errors = {0, 0, 0};
    int places[50], widths[5], at_once = own->runs_at_once;
    uint32_t width = !strcmp(own->gives, "pedals") ? 2 : !strcmp(own->gives, "speed_plan") ? 32 : 1;
    if (!in || !out || !freopen("/dev/null", "r", stdin) || dup2(2, 1) < 0) return 1;
    for (int index = 1; index < argc; index++)
        if (!strncmp(argv[index], "--runs-at-once=", 15) && atoi(argv[index] + 15) < at_once) at_once = atoi(argv[index] + 15);
    for (int byte = getc(in); byte != '\n'; byte = getc(in)) {
        if (byte == EOF) return 0;
        *(char *)sr_make_room(&request, 1) = (char)byte;
    }
    *(char *)sr_make_room(&request, 1) = 0;
    widths[0] = sr_columns(sr_get(request.bytes, "hello"), "runs",
                           "slot time new cruise_speed distance_to_crossing speed acceleration length width lane_width speed_limit "
                           "crossing_width pedestrian_priority signal right_kerb left_kerb", places);
    /* Those of lanes, which are asked for, go on behind. */
    int lanes = sr_columns(sr_get(request.bytes, "hello"), "lanes", 
                           "travelled curvature gradient amber stop_line lateral_offset heading_error", places + 16);
    if (own->curvature && places[21] < 0) return fputs("this runner takes no curvature\n", stderr), 1;
    uint32_t columns = width + 1 + (own->curvature != NULL);
    for (int index = 16; index < 23; index++) if (places[index] >= 0) places[index] += widths[0];
    widths[0] += lanes;
    widths[1] = sr_columns(sr_get(request.bytes, "hello"), "pedestrians", "id x y vx vy ax ay length width", places + 23);
    int kinds = sr_columns(sr_get(request.bytes, "hello"), "kinds", "kind", places + 32);
    if (places[32] >= 0) places[32] += widths[1];
    widths[1] += kinds;
    widths[2] = sr_columns(sr_get(request.bytes, "hello"), "vehicles", "id x y vx vy ax ay length width kind", places + 33);
    widths[3] = sr_columns(sr_get(request.bytes, "hello"), "curvature_ahead", "distance curvature", places + 43);
    widths[4] = sr_columns(sr_get(request.bytes, "hello"), "crossings", "distance width pedestrian_priority right_edge left_edge", places + 45);
    fprintf(out, "{\"hello\":{\"protocol\":1,\"name\":\"%s\",\"version\":\"%s\",\"encoding\":\"f64\",\"tables\":[\"lanes\",\"kinds\",\"crossings\"],\"runs_at_once\":%d,\"gives\":[\"%s\"],"
            "\"modes\":[%s],\"parameters\":[%s]}}\n", own->name, own->version, at_once, own->gives,
            own->modes ? own->modes : "", own->parameters ? own->parameters : "");
    fflush(out);
    /* When each slot was decided last, and what: of runs that stand beside one that was refused, it is asked for again. */
    double *decided = (double *)calloc((size_t)at_once, sizeof(double)), *kept = (double *)calloc((size_t)at_once, 34 * sizeof(double));
    uint32_t head[8];
    while (decided && kept && fread(head, 4, 1, in) == 1) {
        request.used = 0; /* with its length, since rows are aligned from there */
        if (fread((char *)sr_make_room(&request, (size_t)head[0] + 5) + 4, 1, head[0], in) != head[0] || head[0] < 4) return 1;
        request.bytes[head[0] + 4] = 0;
        memcpy(head + 1, request.bytes + 4, 4);
        if (head[1] == 0) {
            const char *text = request.bytes + 8;
            if (sr_get(text, "bye")) break;
            if (sr_get(text, "open")) sr_open(own, sr_get(text, "open"), &answer, decided), sr_send(&answer, out);
            for (const char *one = sr_first(sr_get(text, "close")); one; one = sr_next(one)) {
                char reason[32] = "";
                sr_text(one, "reason", reason, sizeof reason);
                if (own->finish) own->finish((int)sr_number(one, "slot"), reason);
            }
            continue;
        }
        memcpy(head + 1, request.bytes + 4, 28);
        const double *rows = (const double *)(const void *)(request.bytes + 32), *row = rows;
        others.used = 0, rows += head[2] * (uint32_t)widths[0];
        sr_other *other = (sr_other *)sr_make_room(&others, (head[3] + head[4]) * sizeof(sr_other) + 1);
        double *of = (double *)malloc((head[3] + head[4] + 1) * sizeof(double));
        if (!of) return 1;
        for (uint32_t index = 0, one = 0; index < head[3] + head[4]; index++) {
            int is_vehicle = index >= head[3], place = is_vehicle ? 33 : 23;
            of[one] = rows[0]; /* `row` is the first column. */
            sr_pick(rows, places + place, 10, (double *)&other[one]);
            if (isnan(other[one].kind)) other[one].kind = is_vehicle ? SR_VEHICLE : SR_PEDESTRIAN;
            one++;
            rows += widths[1 + is_vehicle];
        }
        bends.used = 0;
        sr_change *change = (sr_change *)sr_make_room(&bends, head[5] * sizeof(sr_change) + 1);
        const double *bend = rows;
        for (uint32_t index = 0; index < head[5]; index++) sr_pick(bend + index * (uint32_t)widths[3], places + 43, 2, (double *)&change[index]);
        zebras.used = 0;
        sr_crossing *crossing = (sr_crossing *)sr_make_room(&zebras, head[6] * sizeof(sr_crossing) + 1);
        const double *zebra = bend + head[5] * (uint32_t)widths[3];
        for (uint32_t index = 0; index < head[6]; index++) sr_pick(zebra + index * (uint32_t)widths[4], places + 45, 5, (double *)&crossing[index]);
        answer.used = 0, errors.used = 0;
        uint32_t after[4] = {0, 2, head[2], columns}, people = 0, cars = head[3], told = 0, crossed = 0;
        memcpy(sr_make_room(&answer, 16), after, 16);
        for (uint32_t run = 0; run < head[2]; run++, row += widths[0]) {
            double values[24], *given = (double *)sr_make_room(&answer, 8 * columns);
            sr_pick(row, places, 23, values);
            int slot = (int)values[0];
            sr_seen seen;
            memcpy(&seen, values + 1, 22 * sizeof(double));
            seen.pedestrian = other + people, seen.vehicle = other + cars;
            for (seen.pedestrians = 0; people < head[3] && of[people] == run; people++) seen.pedestrians++;
            for (seen.vehicles = 0; cars < head[3] + head[4] && of[cars] == run; cars++) seen.vehicles++;
            seen.change = change + told;
            for (seen.changes = 0; told < head[5] && bend[told * (uint32_t)widths[3]] == run; told++) seen.changes++;
            seen.crossing = crossing + crossed;
            for (seen.crossings = 0; crossed < head[6] && zebra[crossed * (uint32_t)widths[4]] == run; crossed++) seen.crossings++;
            if (decided[slot] != seen.time) {
                double *keep = kept + 34 * slot;
                for (uint32_t index = 0; index < width; index++) keep[index] = NAN;
                keep[width] = -1;
                const char *wrong = own->step(slot, &seen, keep, keep + width);
                if (own->curvature && !wrong) keep[width + 1] = own->curvature(slot);
                decided[slot] = wrong ? NAN : seen.time;
                if (wrong) sr_add_slot(&errors, errors.used ? "," : "", slot, wrong);
            }
            memcpy(given, kept + 34 * slot, 8 * columns);
        }
        free(of);
        if (errors.used) {
            sr_begin(&answer), sr_add(&answer, "{\"error\":[");
            memcpy(sr_make_room(&answer, errors.used), errors.bytes, errors.used), sr_add(&answer, "]}");
        }
        sr_send(&answer, out);
    }
    free(request.bytes), free(answer.bytes), free(others.bytes), free(bends.bytes), free(zebras.bytes), free(errors.bytes), free(decided), free(kept);
    return fclose(in) | fclose(out);
}
#endif
