/* Reading of JSON and a conversation over files, under the sanitizers. */
#include "scenario_runner_av.h"
#undef NDEBUG
#include <assert.h>

static int steps[4];

static const char *start(const sr_run *run) {
    char profile[16];
    assert(sr_text(run->parameters, "profile", profile, sizeof profile) && !strcmp(profile, "a \"b\""));
    assert(sr_flag(run->parameters, "yields") && sr_number(run->parameters, "gap") == 2.5);
    assert(run->seed == 9007199254740991u && run->length == 4.5);
    steps[run->slot] = 0;
    return run->slot == 3 ? "no \"weights\"" : NULL;
}

static const char *step(int slot, const sr_seen *seen, double *answer, double *mode) {
    assert(seen->signal == 1.0 && isnan(seen->left_kerb) && seen->speed == 5.0 + slot);
    assert(seen->pedestrians == (slot == 1 ? 2 : 0) && seen->vehicles == (slot == 2));
    assert(seen->curvature == 0.25 && isnan(seen->gradient) && isnan(seen->travelled) && seen->changes == (slot == 0 ? 0 : slot));
    if (slot == 2) assert(seen->change[0].distance == 20 && seen->change[1].distance == 45 && seen->change[1].curvature == 0.02);
    if (slot == 1) assert(seen->change[0].distance == 10 && seen->change[0].curvature == -0.5);
    if (slot == 1) assert(seen->pedestrian[1].id == 8 && seen->pedestrian[1].x == 1.5 && seen->pedestrian[1].width == 0.5);
    if (slot == 1) assert(seen->pedestrian[0].kind == SR_CYCLIST && seen->pedestrian[1].kind == SR_PEDESTRIAN);
    if (slot == 2) assert(seen->vehicle[0].x == 30 && isnan(seen->vehicle[0].ax) && seen->vehicle[0].kind == SR_VEHICLE);
    assert(seen->crossings == (slot == 0 ? 2 : slot == 1));
    if (slot == 0) assert(seen->crossing[1].distance == 40 && seen->crossing[1].left_edge == 2 && isnan(seen->crossing[1].width));
    if (slot == 1) assert(seen->crossing[0].distance == 12.5 && seen->crossing[0].pedestrian_priority == 1);
    *answer = ++steps[slot];
    *mode = 0;
    return slot == 2 && steps[2] == 1 ? "lane\nis \\" : NULL;
}

static void text(FILE *to, const char *said) {
    uint32_t head[2] = {(uint32_t)strlen(said) + 4, 0};
    fwrite(head, 4, 2, to), fwrite(said, 1, strlen(said), to);
}

/* Runs 0, 1 and 2 with columns that are turned around, one of which nobody knows. */
static void scenes(FILE *to, double time, int first_is_new) {
    uint32_t head[8] = {28 + 8 * (3 * 7 + 2 * 5 + 3 + 3 * 3 + 3 * 4), 1, 3, 2, 1, 3, 3, 0};
    double rows[] = {77, 1, 5, time, first_is_new, 0, 0.25, 77, 1, 6, time, 0, 1, 0.25, 77, 1, 7, time, 0, 2, 0.25,
                     1, 0.5, 7, 3.5, 2, 1, 0.5, 8, 1.5, 1, 2, 9, 30, 1, -0.5, 10, 2, 0.01, 20, 2, 0.02, 45,
                     0, 1, 2, 15, 0, 0, 2, 40, 1, 1, 2, 12.5};
    fwrite(head, 4, 8, to), fwrite(rows, 8, sizeof rows / 8, to);
}

static void expect_text(FILE *from, const char *wanted) {
    char said[256] = "";
    uint32_t head[2];
    assert(fread(head, 4, 2, from) == 2 && head[1] == 0 && head[0] - 4 < sizeof said);
    assert(fread(said, 1, head[0] - 4, from) == head[0] - 4);
    if (strcmp(said, wanted)) fprintf(stderr, "%s\n%s\n", said, wanted), exit(1);
}

static void expect_rows(FILE *from, double one, double two, double three) {
    uint32_t head[4];
    double rows[6];
    assert(fread(head, 4, 4, from) == 4 && head[0] == 12 + 48 && head[1] == 2 && head[2] == 3 && head[3] == 2);
    assert(fread(rows, 8, 6, from) == 6 && rows[0] == one && rows[2] == two && rows[4] == three && rows[5] == 0);
}

int main(void) {
    const char *json = "{ \"a\" : [ 1, {\"b\": [\"]\\\"\", 2]}, -3e1 ], \"key\": \"x\\\\\", \"ke\": true, \"none\": [] }";
    const char *list = sr_get(json, "a"), *second = sr_next(sr_first(list));
    char word[3];
    assert(strtod(sr_first(list), NULL) == 1 && strtod(sr_next(sr_first(sr_get(second, "b"))), NULL) == 2);
    assert(strtod(sr_next(second), NULL) == -30 && !sr_next(sr_next(second)) && !sr_first(sr_get(json, "none")));
    assert(sr_flag(json, "ke") && !sr_get(json, "k") && sr_text(json, "key", word, 3) && !strcmp(word, "x\\"));
    assert(!sr_text(json, "key", word, 2) && !sr_text(json, "a", word, 3) && isnan(sr_number(json, "nowhere")));

    FILE *requests = tmpfile(), *answers = tmpfile();
    char name[] = "parts", at_once[] = "--runs-at-once=4", *arguments[] = {name, at_once, NULL}, said[512];
    assert(requests && answers);
    fputs("{\"hello\":{\"columns\":{\"pedestrians\":[\"row\",\"width\",\"id\",\"x\"],\"vehicles\":[\"row\",\"id\",\"x\"],"
          "\"curvature_ahead\":[\"row\",\"curvature\",\"distance\"],\"kinds\":[\"kind\"],"
          "\"crossings\":[\"row\",\"pedestrian_priority\",\"left_edge\",\"distance\"],"
          "\"runs\":[\"later\",\"signal\",\"speed\",\"time\",\"new\",\"slot\"],\"lanes\":[\"curvature\"]},\"protocol\":1}}\n", requests);
    char opened[2048] = "{\"open\":[";
    for (int slot = 0; slot < 4; slot++)
        snprintf(opened + strlen(opened), sizeof opened - strlen(opened),
                 "%s{\"slot\":%d,\"parameters\":{\"gap\":2.5,\"profile\":\"a \\\"b\\\"\",\"yields\":true},\"seed\":9007199254740991,"
                 "\"vehicle\":{\"length\":4.5}}", slot ? "," : "", slot);
    strcat(opened, "]}");
    text(requests, opened);
    /* What stands beside a run that was refused is not decided twice, even at its first decision. */
    scenes(requests, 0, 1), scenes(requests, 0, 1), scenes(requests, 0.1, 0);
    text(requests, "{\"close\":[{\"slot\":0,\"reason\":\"completed\"}]}");
    text(requests, "{\"bye\":{}}");
    fflush(requests), rewind(requests);
    assert(dup2(fileno(requests), 0) == 0 && dup2(fileno(answers), 1) == 1);

    sr_controller own = {"parts", "1", "acceleration", 64, "\"cruise\"", SR_NUMBER(gap, "m", 5, 1, 30) "," SR_FLAG(yields, true), start, step, NULL, NULL};
    assert(sr_serve(&own, 2, arguments) == 0);
    rewind(answers);
    assert(fgets(said, sizeof said, answers) && strstr(said, "\"runs_at_once\":4") && strstr(said, "{\"name\":\"yields\",\"default\":true}"));
    expect_text(answers, "{\"ready\":[0,1,2],\"failed\":[{\"slot\":3,\"message\":\"no \\\"weights\\\"\"}]}");
    expect_text(answers, "{\"error\":[{\"slot\":2,\"message\":\"lane is \\\\\"}]}");
    expect_rows(answers, 1, 1, 2);
    expect_rows(answers, 2, 2, 3);
    assert(fgetc(answers) == EOF);
    return 0;
}
