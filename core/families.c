/* The families of profiles, whether the jerk is bounded or not. */
#include "task.h"

static int jumps(const jounce_family *f) { return !is_finite(f->task.rise); }

void jounce_make_family(jounce_family *f) {
    if (jumps(f)) {
        jounce_speed_family(f);
    } else {
        jounce_jerk_family(f);
    }
}

double jounce_blur(const jounce_family *f) {
    return jumps(f) ? jounce_speed_blur(f) : jounce_jerk_blur(f);
}

void jounce_solutions(const jounce_family *f, jounce_profiles *found) {
    if (jumps(f)) {
        jounce_speed_solutions(f, found);
    } else {
        jounce_jerk_solutions(f, found);
    }
}

int jounce_lasting(const jounce_family *f, double duration, jounce_profile *profile) {
    return jumps(f) ? jounce_speed_lasting(f, duration, profile)
                       : jounce_jerk_lasting(f, duration, profile);
}

int jounce_edges(const jounce_family *f, double *durations) {
    return jumps(f) ? jounce_speed_edges(f, durations) : jounce_jerk_edges(f, durations);
}

double jounce_distance_of(const jounce_family *f, const jounce_profile *profile) {
    return jumps(f) ? jounce_speed_distance(f, profile) : jounce_jerk_distance(f, profile);
}

int jounce_lengths_of(const jounce_family *f, const jounce_profile *profile, double *lengths) {
    return jumps(f) ? jounce_speed_lengths(f, profile, lengths)
                    : jounce_jerk_lengths(f, profile, lengths);
}

void jounce_pieces_of(const jounce_family *f, const jounce_profile *profile, double start,
                      double end, jounce_motion *motion) {
    if (jumps(f)) {
        jounce_speed_pieces(f, profile, start, end, motion);
    } else {
        jounce_jerk_pieces(f, profile, start, end, motion);
    }
}

int jounce_shortest(const jounce_family *f, double begins, jounce_profile *best) {
    jounce_profiles found;
    int i, at = 0;
    if (!jumps(f)) {
        return jounce_jerk_shortest(f, begins, best);
    }
    jounce_solutions(f, &found);
    for (i = 1; i < found.count; i++) {
        if (found.profiles[i].duration < found.profiles[at].duration) {
            at = i;
        }
    }
    if (found.count > 0) {
        *best = found.profiles[at];
    }
    return found.count > 0;
}
