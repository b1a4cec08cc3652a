/* Profiles of bounded acceleration: speed up to a peak velocity, cruise, slow down.
 *
 * The profile that goes furthest in its time accelerates at a_max to a peak velocity w, cruises
 * where w = v_max, and decelerates at a_min (Thompson, Section II, with any velocity at both
 * ends):
 *
 *     distance = (w^2 - v0^2)/(2 a_max) + (w^2 - v1^2)/(2 |a_min|) + v_max cruise,
 *     w >= max(v0, v1) = least.
 *
 * Both roots w can be profiles, the one of the lower w the shorter: between their durations the
 * distance cannot be covered at all. What is kept is p = w - least, so that a small rise of a fast
 * motion keeps its digits, and q = w.
 */
#include "task.h"

static double least_of(const jounce_task *t) { return larger(t->v0, t->v1); }

static jounce_profile speed_timed(const jounce_task *t, double w, double rise, double cruise) {
    double least = least_of(t);
    jounce_profile profile = {0};
    profile.duration =
        (least - t->v0 + rise) / t->a_max + (t->v1 - least - rise) / t->a_min + cruise;
    profile.p = rise;
    profile.q = w;
    profile.cruise = cruise;
    return profile;
}

static double travelled(const jounce_task *t, double w) {
    return (w - t->v0) * (w + t->v0) * 0.5 / t->a_max + (t->v1 - w) * (t->v1 + w) * 0.5 / t->a_min;
}

/* The bound that leads from v0 to v1 at once; the other one takes no part in the way. */
static double used_bound(const jounce_task *t) {
    if (t->v0 == t->v1) {
        return larger(t->a_max, -t->a_min);
    }
    return t->v0 < t->v1 ? t->a_max : -t->a_min;
}

void jounce_speed_family(jounce_family *family) {
    const jounce_task *t = &family->task;
    family->speed = larger(magnitude(t->v0), magnitude(t->v1));
    family->rounding = t->resolution + ROUNDING * magnitude(t->distance);
}

double jounce_speed_blur(const jounce_family *family) {
    double stop = family->speed * family->speed / used_bound(&family->task);
    return family->rounding + ROUNDING * stop;
}

static void found_at(const jounce_task *t, double w, double rise, double cruise,
                     jounce_profiles *found) {
    found->profiles[found->count++] = speed_timed(t, w, rise, cruise);
}

void jounce_speed_solutions(const jounce_family *family, jounce_profiles *found) {
    const jounce_task *t = &family->task;
    double least = least_of(t), missing, gain, square, slack;
    found->count = 0;
    if (least > t->v_max) {
        return;
    }
    missing = t->distance - travelled(t, least);
    slack = ROUNDING * family->speed * speed_timed(t, least, 0.0, 0.0).duration;
    /* what a small change of velocity does not gain takes a way round */
    slack += missing * least > 0.0 ? family->rounding : jounce_speed_blur(family);
    if (magnitude(missing) <= slack) {
        found_at(t, least, 0.0, 0.0, found);
    }
    gain = missing / (0.5 / t->a_max - 0.5 / t->a_min);
    square = least * least + gain;
    if (magnitude(square) <= ROUNDING * least * least) {
        square = 0.0;
    }
    if (square >= 0.0) {
        double root = square_root(square);
        double other = least > 0.0 ? gain / (root + least) : root - least;
        if (least < 0.0 && root > 0.0 && gain / (least - root) > 0.0) { /* w = -root */
            found_at(t, -root, gain / (least - root), 0.0, found);
        }
        if (other > 0.0 && (root <= t->v_max || other <= t->v_max - least)) {
            found_at(t, smaller(root, t->v_max), other, 0.0, found);
        }
    }
    if (is_finite(t->v_max) && t->v_max > 0.0) {
        double rest = t->distance - travelled(t, t->v_max);
        if (rest >= 0.0) {
            found_at(t, t->v_max, t->v_max - least, rest / t->v_max, found);
        }
    }
}

int jounce_speed_lasting(const jounce_family *family, double duration, jounce_profile *profile) {
    const jounce_task *t = &family->task;
    double least = least_of(t), more, rise;
    double shortest = speed_timed(t, least, 0.0, 0.0).duration;
    if (duration < shortest * (1.0 - ROUNDING)) {
        return 0;
    }
    more = larger(duration - shortest, 0.0);
    rise = more / (1.0 / t->a_max - 1.0 / t->a_min);
    if (least + rise <= t->v_max) {
        *profile = speed_timed(t, least + rise, rise, 0.0);
    } else {
        *profile = speed_timed(t, t->v_max, t->v_max - least, 0.0);
        profile->cruise = larger(duration - profile->duration, 0.0);
    }
    profile->duration = duration;
    return 1;
}

int jounce_speed_edges(const jounce_family *family, double *durations) {
    const jounce_task *t = &family->task;
    durations[0] = speed_timed(t, least_of(t), 0.0, 0.0).duration;
    return 1;
}

double jounce_speed_distance(const jounce_family *family, const jounce_profile *profile) {
    return travelled(&family->task, profile->q) + profile->q * profile->cruise;
}

int jounce_speed_lengths(const jounce_family *family, const jounce_profile *profile,
                         double *lengths) {
    const jounce_task *t = &family->task;
    double least = least_of(t);
    lengths[0] = (least - t->v0 + profile->p) / t->a_max;
    lengths[1] = profile->cruise;
    lengths[2] = (t->v1 - least - profile->p) / t->a_min;
    return 3;
}

void jounce_speed_pieces(const jounce_family *family, const jounce_profile *profile, double start,
                         double end, jounce_motion *motion) {
    const jounce_task *t = &family->task;
    double w = profile->q, lengths[JOUNCE_MOST_LENGTHS], up, down;
    jounce_speed_lengths(family, profile, lengths);
    up = lengths[0];
    down = lengths[2];
    jounce_add(motion, up, start, t->v0, t->a_max, 0.0);
    jounce_add(motion, lengths[1], start + 0.5 * (t->v0 + w) * up, w, 0.0, 0.0);
    jounce_add(motion, down, end - 0.5 * (w + t->v1) * down, w, t->a_min, 0.0);
}
