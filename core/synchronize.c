/* Several axes at once: the shortest duration that every one of them can take.
 *
 * The durations that an axis can take need not be an interval: one that moves at its start and end
 * may be able to pass quickly, or to turn back and pass again, and take no time in between.
 */
#include "task.h"

/* The shortest possible duration that is no shorter than the one given. */
static double next_possible(const jounce_durations *possible, double duration) {
    int i;
    for (i = 0; i < possible->count; i++) {
        const jounce_interval *each = &possible->intervals[i];
        if (duration <= each->high * (1.0 + ROUNDING)) {
            return each->low > duration * (1.0 + ROUNDING) ? each->low : duration;
        }
    }
    return INFINITE;
}

double jounce_common_duration(const jounce_durations *possible, int axes) {
    double duration = 0.0, following;
    int i, round;
    for (round = 0; round <= axes * JOUNCE_MOST_INTERVALS; round++) {
        following = duration;
        for (i = 0; i < axes; i++) {
            following = larger(following, next_possible(&possible[i], duration));
        }
        if (following <= duration || !is_finite(following)) {
            return following;
        }
        duration = following;
    }
    return INFINITE;
}

jounce_status jounce_synchronize(const jounce_state *starts, const jounce_state *ends,
                                 const jounce_limits *limits, int axes,
                                 jounce_durations *possible, jounce_motion *motions,
                                 int *failed) {
    double together;
    int i;
    for (i = 0; i < axes; i++) {
        jounce_status status =
            jounce_possible_durations(&starts[i], &ends[i], &limits[i], &possible[i]);
        *failed = i;
        if (status != JOUNCE_OK) {
            return status;
        }
    }
    *failed = -1;
    together = jounce_common_duration(possible, axes);
    if (!is_finite(together)) {
        return JOUNCE_NO_DURATION;
    }
    for (i = 0; i < axes; i++) {
        jounce_status status = jounce_transfer(&starts[i], &ends[i], &limits[i], &motions[i]);
        if (status != JOUNCE_OK || motions[i].duration < together * (1.0 - ROUNDING)) {
            status =
                jounce_transfer_lasting(&starts[i], &ends[i], &limits[i], together, &motions[i]);
        }
        if (status != JOUNCE_OK) {
            *failed = i;
            return status;
        }
    }
    return JOUNCE_OK;
}
