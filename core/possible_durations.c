/* The durations that a transfer can take. */
#include "task.h"

enum { MOST_EDGES = 128 };

/* Whether the task's distance can be covered in a duration. */
static int covers(const jounce_task *task, const jounce_family *up, const jounce_family *down,
                  double duration) {
    jounce_profile highest, lowest;
    return jounce_lasting(up, duration, &highest) && jounce_lasting(down, duration, &lowest) &&
           -jounce_distance_of(down, &lowest) <= task->distance &&
           task->distance <= jounce_distance_of(up, &highest);
}

static void sort(double *values, int count) {
    int i, j;
    for (i = 1; i < count; i++) {
        double value = values[i];
        for (j = i; j > 0 && values[j - 1] > value; j--) {
            values[j] = values[j - 1];
        }
        values[j] = value;
    }
}

static void add_interval(double low, double high, jounce_durations *out) {
    jounce_interval *last = &out->intervals[out->count - 1];
    if (out->count > 0 && low <= last->high * (1.0 + ROUNDING)) {
        last->high = high;
    } else if (out->count < JOUNCE_MOST_INTERVALS) {
        out->intervals[out->count].low = low;
        out->intervals[out->count++].high = high;
    }
}

static int is_among(double value, const double *values, int count) {
    int i;
    for (i = 0; i < count; i++) {
        if (values[i] == value) {
            return 1;
        }
    }
    return 0;
}

/* For a given duration the distances that can be covered are an interval, from the furthest down
 * to the furthest up, so that the possible durations change only where one of the two families
 * covers the task's distance, begins or ends. */
static void possible(const jounce_task *task, jounce_durations *out) {
    jounce_family up, down;
    jounce_profiles found;
    double marks[MOST_EDGES], solved[2 * JOUNCE_MOST_PROFILES];
    int count, solutions_count = 0, i;
    up.task = *task;
    down.task = jounce_mirrored(task);
    jounce_make_family(&up);
    jounce_make_family(&down);
    out->count = 0;
    jounce_solutions(&up, &found);
    for (i = 0; i < found.count; i++) {
        solved[solutions_count++] = found.profiles[i].duration;
    }
    jounce_solutions(&down, &found);
    for (i = 0; i < found.count; i++) {
        solved[solutions_count++] = found.profiles[i].duration;
    }
    if (solutions_count == 1 && task->a0 * task->a1 <= 0.0) { /* nothing turns round later */
        add_interval(solved[0], INFINITE, out);
        return;
    }
    count = jounce_edges(&up, marks);
    count += jounce_edges(&down, marks + count);
    for (i = 0; i < solutions_count && count < MOST_EDGES - 1; i++) {
        marks[count++] = solved[i];
    }
    if (count == 0) {
        return;
    }
    sort(marks, count);
    marks[count] = 2.0 * marks[count - 1] + 1.0;
    for (i = 0; i < count; i++) {
        double left = marks[i], right = i + 1 < count ? marks[i + 1] : INFINITE;
        double middle = i + 1 < count ? 0.5 * (left + right) : marks[count];
        if (left == right) {
            continue;
        }
        if (covers(task, &up, &down, middle)) {
            add_interval(left, right, out);
        } else if (is_among(left, solved, solutions_count) &&
                   !(out->count > 0 && out->intervals[out->count - 1].high == left)) {
            add_interval(left, left, out);
        }
    }
}

jounce_status jounce_possible_durations(const jounce_state *start, const jounce_state *end,
                                        const jounce_limits *limits,
                                        jounce_durations *durations) {
    jounce_problem p;
    int i;
    jounce_pose(start, end, limits, jounce_size_of_positions(start, end), 0.0, &p);
    durations->count = 0;
    if (p.status != JOUNCE_OK) {
        return p.status;
    }
    jounce_start_inside(&p);
    possible(&p.task, durations);
    for (i = 0; i < durations->count; i++) {
        jounce_interval *each = &durations->intervals[i];
        each->low = scaled(each->low + p.way.duration, p.units.time);
        each->high = scaled(each->high + p.way.duration, p.units.time);
    }
    return durations->count > 0 ? JOUNCE_OK : JOUNCE_UNREACHABLE;
}
