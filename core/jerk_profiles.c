/* Profiles of bounded jerk: the two families among which the fastest motion is.
 *
 * For a given duration the profile that goes furthest has the acceleration
 *
 *     rise to p, hold, fall to q, hold, rise to a1,    p <= a_max, q >= a_min, holds only at the
 *                                                      bounds,
 *
 * broken by a cruise at v_max where the fall crosses zero: the costate of the acceleration is
 * convex in time. With kappa = 1/(2 rise) + 1/(2 fall) the end velocity asks
 *
 *     kappa (p^2 - q^2) + a_max hold + a_min dwell = c = v1 - v0 + (a0^2 - a1^2)/(2 rise),
 *
 * which leaves a one-parameter family of arcs. Along each arc the duration grows monotonically,
 * and the distance d changes with it by dd/dT = H, the Hamiltonian, a polynomial of degree two at
 * most in the arc's parameter (in w^2 with w = p - q on the arc without holds). So d is monotone
 * between the known zeros of H, and each monotone stretch holds at most one profile of the
 * distance wanted, found to the last bit by a bracketed Newton iteration. The profiles that go the
 * least far are the same family of the mirrored task; the fastest motion is the shortest one of
 * either family.
 *
 * Source: the structures are those of Ruckig's step 1 (Berscheid & Kroger, "Jerk-limited real-time
 * trajectory generation with arbitrary target states", 2021); the families and their Hamiltonian
 * follow Wang & Hu, arXiv 2311.07039.
 */
#include "task.h"

/* The parameter of an arc: q, p, q (p at its bound), p (q at its bound), the hold's duration. */
enum { FREE_Q, FREE_P, HOLD, DWELL, BOTH };

/* One structure of a family, over a range of its parameter in which the duration grows. An
 * acceleration is counted from `origin`, zero or the one at that end of the motion, of which a slow
 * jerk may change but its last digits. */
typedef struct {
    int kind;
    double origin, first, last;
} Arc;

enum { MOST_ARCS = 12, MOST_STEPS = 2200 }; /* steps: of a root 300 decades below its bracket */

typedef struct {
    int count;
    Arc arcs[MOST_ARCS];
} Arcs;

#define HARDLY 1e-6 /* a time that does not count beside those of order one */

/* --- what depends on the task alone ------------------------------------------------------------ */

/* The peak between which and velocity v, acceleration a, v_max is just reached. */
static inline jounce_peak to_cruise(const jounce_family *f, double v, double a) {
    double v_max = f->task.v_max, left = v_max - v, square;
    double slack = ROUNDING * (magnitude(v_max) + magnitude(v));
    const double halves[] = {f->half_rise, -f->half_fall};
    const int is_above = a > 0.0;
    jounce_peak peak = {INFINITE, INFINITE};
    if (!is_finite(v_max)) {
        return peak;
    }
    square = a * a * halves[is_above]; /* beyond a, or zero */
    if (left + square < -slack - ROUNDING * magnitude(square)) {
        peak.size = peak.beyond = -INFINITE;
        return peak;
    }
    peak.size = square_root(larger(left + a * a * f->half_rise, 0.0) * f->per_kappa);
    if (is_above) {
        peak.beyond = larger(left + square, 0.0) * f->per_kappa / (peak.size + a);
        peak.size = a + peak.beyond;
    } else {
        peak.beyond = peak.size - a;
    }
    return peak;
}

/* Whether a rise from zero acceleration to `a` that ends at v starts within v_min. */
static int may_rise_to(const jounce_family *f, double v, double a) {
    double square = a * a * f->half_rise, lowest = f->task.v_min;
    double slack = ROUNDING * (magnitude(lowest) + magnitude(v) + square);
    return a <= 0.0 || v - square >= lowest - slack;
}

static void view_both_ways(jounce_family *f) {
    const jounce_task *t = &f->task;
    int uneven = larger(t->rise, t->fall) > 64.0 * smaller(t->rise, t->fall);
    jounce_peak p = to_cruise(f, t->v0, t->a0), q = to_cruise(f, t->v1, -t->a1);
    int may_dip = may_rise_to(f, t->v1, t->a1), may_rise = may_rise_to(f, t->v0, -t->a0);
    jounce_view ahead = {t->a0, t->a1, t->v1 - t->v0, t->v1,   f->ratio, t->a_max, t->a_min,
                         p,     q,     may_rise,      may_dip, uneven};
    jounce_view back = {-t->a1, -t->a0, t->v0 - t->v1, t->v0,    -f->ratio, -t->a_min, -t->a_max,
                        q,      p,      may_dip,       may_rise, uneven};
    f->ahead = ahead;
    f->back = back;
}

double jounce_jerk_blur(const jounce_family *f) {
    const jounce_task *t = &f->task;
    double jerk = smaller(t->rise, t->fall);
    double stop = f->speed / smaller(t->a_max, -t->a_min) + square_root(f->speed / jerk) +
                  larger(magnitude(t->a0), magnitude(t->a1)) / jerk;
    return f->rounding + ROUNDING * f->speed * stop;
}

void jounce_jerk_family(jounce_family *f) {
    const jounce_task *t = &f->task;
    double square;
    f->speed = larger(magnitude(t->v0), magnitude(t->v1));
    f->rounding = t->resolution + ROUNDING * magnitude(t->distance);
    f->rise_time = 1.0 / t->rise;
    f->fall_time = 1.0 / t->fall;
    f->half_rise = 0.5 * f->rise_time;
    f->half_fall = 0.5 * f->fall_time;
    f->kappa = f->half_rise + f->half_fall;
    f->per_kappa = 1.0 / f->kappa;
    square = (t->a0 - t->a1) * (t->a0 + t->a1) * f->half_rise;
    f->ratio = (t->v1 - t->v0 + square) * f->per_kappa;
    if (magnitude(f->ratio) * f->kappa <= ROUNDING * (f->speed + magnitude(square))) {
        f->ratio = 0.0;
    }
    view_both_ways(f);
}

/* --- the arcs ---------------------------------------------------------------------------------- */

/* An acceleration, and how far it lies above a1. */
typedef struct {
    double value, offset;
} Place;

static Place located(double value, double offset) {
    Place result;
    result.value = value;
    result.offset = offset;
    return result;
}

static int is_above(Place a, Place b) {
    return a.value > b.value || (a.value == b.value && a.offset > b.offset);
}

static Place lower_of(Place a, Place b) { return is_above(a, b) ? b : a; }

static Place upper_of(Place a, Place b) { return is_above(a, b) ? a : b; }

static Place above_zero(jounce_peak q, double a1) {
    return located(q.size, a1 > 0.0 ? q.beyond : q.size - a1);
}

static Place below_zero(jounce_peak q, double a1) {
    return located(-q.size, a1 < 0.0 ? -q.beyond : -q.size - a1);
}

/* Add an arc in q as it is seen in a view. */
static void add_arc(Arcs *arcs, int kind, double origin, double first, double last) {
    double sign = kind == FREE_P || kind == DWELL ? -1.0 : 1.0;
    if (arcs->count < MOST_ARCS) {
        Arc arc = {kind, sign * origin, sign * first, sign * last};
        arcs->arcs[arcs->count++] = arc;
    }
}

/* Add the arc of falling q between two places, each part counted from where its digits are. */
static void add_between(const jounce_view *t, int kind, Place first, Place last, Arcs *arcs) {
    double a1 = t->a1, half = t->uneven ? 0.5 * a1 : INFINITE;
    if (is_above(last, first)) {
        return;
    }
    if (a1 < 0.0 || (a1 > 0.0 && last.value >= half)) {
        add_arc(arcs, kind, a1, first.offset, last.offset);
    } else if (first.value <= half) {
        add_arc(arcs, kind, 0.0, first.value, last.value);
    } else {
        add_arc(arcs, kind, a1, first.offset, -half);
        add_arc(arcs, kind, 0.0, half, last.value);
    }
}

/* The two arcs in falling q: from `start` to `least`, and from there with the other sign to -high. */
static void add_in_q(const jounce_view *t, int kind, Place start, jounce_peak least,
                     jounce_peak high, Arcs *arcs) {
    double a1 = t->a1;
    Place end = above_zero(least, a1), bottom = located(0.0, -a1);
    if (!t->may_rise) {
        return;
    }
    if (t->may_dip) {
        bottom = upper_of(located(t->bottom, t->bottom - a1),
                          located(-t->q_cruise.size, -t->q_cruise.beyond));
        bottom = upper_of(bottom, below_zero(high, a1));
    }
    if (!is_above(end, start)) {
        if (end.value == 0.0 && bottom.value < 0.0) {
            add_between(t, kind, start, bottom, arcs);
            return;
        }
        add_between(t, kind, start, end, arcs);
    }
    add_between(t, kind, lower_of(located(a1, 0.0), below_zero(least, a1)), bottom, arcs);
}

/* The size of q, and how far it is beyond that of a1, where the profile without holds has a peak p;
 * zero within rounding, and `none` where there is none. */
static jounce_peak meets(const jounce_family *f, const jounce_view *t, double p, double none) {
    double rising = (p - t->a0) * (p + t->a0) * f->half_rise, falling = p * p * f->half_fall;
    double last = t->a1 * t->a1 * f->half_rise, size = magnitude(t->a1);
    double square = rising + falling + last - t->gain;
    double noise = ROUNDING * (magnitude(rising) + falling + last + f->speed);
    jounce_peak q = {0.0, 0.0};
    if (square > noise) {
        q.size = square_root(square * f->per_kappa);
    } else {
        q.size = square < -noise ? none : 0.0;
    }
    q.beyond = q.size - size;
    if (t->uneven && size > 0.0 && square > noise) {
        square = rising + (p - size) * (p + size) * f->half_fall - t->gain;
        q.beyond = square * f->per_kappa / (q.size + size);
    }
    return q;
}

/* What the three ramps of a profile gain of velocity. */
static inline double gain_of_ramps(const jounce_family *f, const jounce_view *t,
                                   const jounce_profile *profile) {
    double p = profile->p, q = profile->q;
    return (profile->first * (p + t->a0) + profile->last * (q + t->a1)) * f->half_rise +
           profile->fall * (p + q) * f->half_fall;
}

static jounce_profile holding_both(const jounce_family *f) {
    const jounce_task *t = &f->task;
    jounce_profile profile = {0};
    profile.p = t->a_max;
    profile.q = t->a_min;
    profile.first = t->a_max - t->a0;
    profile.fall = t->a_max - t->a_min;
    profile.last = t->a1 - t->a_min;
    return profile;
}

/* Whether the accelerations at the ends leave the family without a profile. */
static int is_empty(const jounce_family *f) {
    return f->task.a0 > f->task.a_max || f->task.a1 < f->task.a_min;
}

/* The last arc, on which both bounds are held. */
static void find_longest(const jounce_family *f, Arcs *arcs) {
    const jounce_task *t = &f->task;
    jounce_profile both;
    double p, top, first, last;
    if (!(is_finite(t->a_max) && is_finite(t->a_min) && f->ahead.may_dip && f->ahead.may_rise)) {
        return;
    }
    both = holding_both(f);
    p = both.p;
    top = both.first * (p + t->a0) * f->half_rise + p * p * f->half_fall;
    first = larger(f->ahead.gain - gain_of_ramps(f, &f->ahead, &both), 0.0) / p;
    last = (t->v_max - t->v0 - top) / p;
    if (first <= last) {
        add_arc(arcs, BOTH, 0.0, first, last);
    }
}

static void find_free(const jounce_family *f, Arcs *arcs) {
    int kind = f->ratio >= 0.0 ? FREE_Q : FREE_P;
    const jounce_view *t = kind == FREE_Q ? &f->ahead : &f->back;
    jounce_peak least = {0.0, 0.0}, high = {INFINITE, INFINITE};
    least.beyond = -magnitude(t->a1);
    if (t->a0 > 0.0) {
        least = meets(f, t, t->a0, 0.0);
    }
    if (is_finite(t->top)) {
        high = meets(f, t, t->top, -INFINITE);
    }
    add_in_q(t, kind, lower_of(located(t->a1, 0.0), above_zero(high, t->a1)), least, high, arcs);
}

static void find_held(const jounce_family *f, const jounce_view *t, int kind, Arcs *arcs) {
    jounce_peak any = {INFINITE, INFINITE};
    Place start = lower_of(located(t->a1, 0.0), located(t->top, t->top - t->a1));
    if (is_finite(t->top)) {
        add_in_q(t, kind, start, meets(f, t, t->top, 0.0), any, arcs);
    }
}

/* The arcs on which one bound is held at most. */
static void find_shorter(const jounce_family *f, Arcs *arcs) {
    const jounce_task *t = &f->task;
    if (f->ratio == 0.0 && t->a0 <= t->a1 && t->a1 < 0.0) { /* nothing but the rise */
        add_arc(arcs, FREE_P, -t->a0, t->a0 - t->a1, t->a0 - t->a1);
    }
    find_free(f, arcs);
    find_held(f, &f->ahead, HOLD, arcs);
    find_held(f, &f->back, DWELL, arcs);
}

/* The arcs of the family without cruise. */
static void find_arcs(const jounce_family *f, Arcs *arcs) {
    arcs->count = 0;
    if (!is_empty(f)) {
        find_shorter(f, arcs);
        find_longest(f, arcs);
    }
}

static inline void set_duration(const jounce_family *f, jounce_profile *profile) {
    profile->duration = larger((profile->first + profile->last) * f->rise_time +
                                   profile->fall * f->fall_time, 0.0) +
                        profile->hold + profile->dwell;
}

/* The profile of a q, seen in a view. Each ramp is found from differences, not as the difference of
 * two accelerations, which may nearly agree. */
static inline jounce_profile from_q(const jounce_family *f, const jounce_view *t, int held,
                                    double origin, double s) {
    double a0 = t->a0, q = origin + s, p = t->top, left;
    jounce_profile profile = {0};
    profile.q = q;
    profile.last = t->a1 - origin - s;
    if (held) {
        profile.p = p;
        profile.first = p - a0;
        profile.fall = p - origin - s;
        profile.hold = larger((t->gain - gain_of_ramps(f, t, &profile)) / p, 0.0);
        return profile;
    }
    p = square_root(larger(t->ratio + q * q, 0.0));
    if (a0 > 0.0 && t->uneven) {
        left = t->gain - profile.last * (q + t->a1) * f->half_rise;
        left += (origin - a0 + s) * (q + a0) * f->half_fall;
        profile.first = larger(left * f->per_kappa / (p + a0), 0.0);
        p = a0 + profile.first;
    } else {
        p = larger(p, a0);
        profile.first = p - a0;
    }
    profile.p = p;
    if (q <= 0.0 || !t->uneven) {
        profile.fall = p - q;
    } else if (f->fall_time > f->rise_time) {
        profile.fall = t->ratio / (p + q);
    } else {
        profile.fall = larger(profile.first + profile.last + (a0 - t->a1), 0.0);
    }
    return profile;
}

/* The member of an arc at parameter s. */
static inline jounce_profile member(const jounce_family *f, const Arc *arc, double s) {
    jounce_profile profile, other;
    if (arc->kind == BOTH) {
        profile = holding_both(f);
        profile.hold = s;
        profile.dwell = larger((f->ahead.gain - gain_of_ramps(f, &f->ahead, &profile) -
                                profile.p * s) / profile.q, 0.0);
    } else if (arc->kind == FREE_Q || arc->kind == HOLD) {
        profile = from_q(f, &f->ahead, arc->kind == HOLD, arc->origin, s);
    } else {
        other = profile = from_q(f, &f->back, arc->kind == DWELL, -arc->origin, -s);
        profile.p = -other.q;
        profile.q = -other.p;
        profile.first = other.last;
        profile.last = other.first;
        profile.hold = 0.0;
        profile.dwell = other.hold;
    }
    set_duration(f, &profile);
    return profile;
}

/* The derivative of the duration by the parameter. */
static inline double duration_slope(const jounce_family *f, int kind, const jounce_profile *profile) {
    double p = profile->p, q = profile->q;
    switch (kind) {
    case FREE_Q:
    case HOLD:
        return p != 0.0 ? -2.0 * f->kappa * profile->fall / p : -2.0 * f->kappa;
    case FREE_P:
    case DWELL:
        return q != 0.0 ? -2.0 * f->kappa * profile->fall / q : 2.0 * f->kappa;
    default:
        return 1.0 - p / q;
    }
}

/* --- distance ---------------------------------------------------------------------------------- */

typedef struct {
    double distance, slope, scale; /* without the cruise; its derivative by the duration; rounding */
} Travel;

/* Velocities at both ends of the fall, that before it reckoned from the start and that after it from
 * the end; the distances from the start and to the end; and which of the two knows more digits. */
typedef struct {
    double v, w, x, y;
    double fastest[2];
} Ends;

static inline Ends ends_of_fall(const jounce_family *f, const jounce_profile *profile) {
    const jounce_task *t = &f->task;
    double p = profile->p, q = profile->q, hold = profile->hold, dwell = profile->dwell;
    Ends e;
    e.v = t->v0;
    e.w = t->v1;
    e.x = ramp_in(&e.v, t->a0, p, profile->first * f->rise_time);
    e.fastest[0] = larger(magnitude(t->v0), magnitude(e.v));
    e.x += (e.v + 0.5 * p * hold) * hold;
    e.v += p * hold;
    e.y = -ramp_in(&e.w, t->a1, q, -profile->last * f->rise_time);
    e.fastest[1] = larger(magnitude(t->v1), magnitude(e.w));
    e.y += (e.w - 0.5 * q * dwell) * dwell;
    e.w -= q * dwell;
    e.fastest[0] = larger(e.fastest[0], magnitude(e.v));
    e.fastest[1] = larger(e.fastest[1], magnitude(e.w));
    return e;
}

/* The fall is reckoned from the end of it that knows more digits, which is chosen without a branch:
 * a processor cannot guess it. */
static inline Travel travel(const jounce_family *f, const jounce_profile *profile) {
    const double p = profile->p, q = profile->q, time = profile->fall * f->fall_time;
    const Ends e = ends_of_fall(f, profile);
    const double speeds[] = {e.v, e.w}, from[] = {p, q}, to[] = {q, p}, times[] = {time, -time};
    const int rear = e.fastest[1] < e.fastest[0];
    const double v = speeds[rear], a = from[rear], end = to[rear], t = times[rear];
    Travel result;
    result.slope = v + 0.5 * a * t;
    result.distance = e.x + (v + (2.0 * a + end) * (1.0 / 6.0) * t) * time + e.y;
    result.scale = e.fastest[0] * (profile->first * f->rise_time + profile->hold) +
                   e.fastest[1] * (profile->last * f->rise_time + profile->dwell) +
                   larger(e.fastest[rear], magnitude(v + 0.5 * (a + end) * t)) * time;
    return result;
}

/* The real roots of a x^2 + b x + c, without cancellation. */
static int quadratic(double a, double b, double c, double *roots) {
    double discriminant = b * b - 4.0 * a * c, half;
    if (discriminant < 0.0) {
        return 0;
    }
    half = square_root(discriminant);
    half = -0.5 * (b + (b >= 0.0 ? half : -half));
    roots[0] = 0.0;
    if (half == 0.0) {
        return 1;
    }
    roots[0] = half / a;
    roots[1] = c / half;
    return 2;
}

/* The parameters at which the distance may turn: the zeros of H on an arc. */
static int turning_points(const jounce_family *f, const Arc *arc, double *points) {
    int kind = arc->kind, n, i, count = 0;
    int is_back = kind == FREE_P || kind == DWELL;
    const jounce_view *t = is_back ? &f->back : &f->ahead;
    double p = t->top, origin = is_back ? -arc->origin : arc->origin, a1 = t->a1, roots[2];
    if (kind == BOTH) {
        jounce_profile both = holding_both(f);
        points[0] = -(f->task.v0 + both.first * (p + t->a0) * f->half_rise +
                      p * both.fall * f->half_fall) / p;
        return 1;
    }
    if (kind == HOLD || kind == DWELL) {
        n = quadratic(f->kappa, -2.0 * a1 * f->half_rise - (a1 + a1 - p) * f->half_fall,
                      t->v1 - (p - a1) * a1 * f->half_fall, roots);
        for (i = 0; i < n; i++) {
            points[count++] = a1 - origin - roots[i];
        }
    } else {
        double alpha = 0.25 * f->half_rise + 0.5 * f->half_fall;
        double gamma = t->v1 - 0.5 * t->gain - 0.5 * (t->a0 * t->a0 + a1 * a1) * f->half_rise;
        double beta = 0.25 * t->ratio * t->ratio * f->half_rise;
        n = quadratic(alpha, gamma, beta, roots);
        for (i = 0; i < n; i++) {
            if (roots[i] > 0.0) {
                double w = square_root(roots[i]);
                points[count++] = -0.5 * w + 0.5 * t->ratio / w - origin;
            }
        }
    }
    for (i = 0; i < count && is_back; i++) {
        points[i] = -points[i];
    }
    return count;
}

/* --- profiles of a given distance --------------------------------------------------------------- */

/* What of the distance rounding of the states is worth in this time. */
static inline double most_blur(const jounce_family *f, double duration) {
    return f->rounding + ROUNDING * f->speed * duration;
}

/* Whether an error of the distance is worth no more than that, beside what is allowed for. */
static int is_blur(const jounce_family *f, double error, double allowed, double duration) {
    double more = magnitude(error) - allowed;
    return more <= most_blur(f, duration) && more <= jounce_jerk_blur(f);
}

static void keep(const jounce_profile *profile, jounce_profiles *found) {
    if (found->count < JOUNCE_MOST_PROFILES) {
        found->profiles[found->count++] = *profile;
    }
}

/* A parameter beyond which the distance wanted is exceeded for good; 0 where there is none. */
static int far_parameter(const jounce_family *f, const Arc *arc, double s, double infinite,
                         double *far) {
    double step = infinite > 0.0 ? 1.0 : -1.0;
    while (magnitude(step) < 1e100) {
        jounce_profile profile = member(f, arc, s + step);
        Travel there = travel(f, &profile);
        if (there.slope > 0.0 && there.distance > f->task.distance) {
            *far = s + step;
            return 1;
        }
        step *= 2.0;
    }
    return 0;
}

/* A member of an arc: by how much its distance errs, and the distance's derivative by the duration. */
typedef struct {
    double s, error, slope;
    double scale; /* of rounding */
    jounce_profile profile;
} Point;

static inline void measure(const jounce_family *f, Point *at) {
    Travel there = travel(f, &at->profile);
    at->error = there.distance - f->task.distance;
    at->slope = there.slope;
    at->scale = there.scale;
}

/* The derivative of the distance by the parameter. */
static inline double steepness(const jounce_family *f, int kind, const Point *at) {
    return at->slope * duration_slope(f, kind, &at->profile);
}

/* How much longer to hold the upper bound, the lower one accordingly, until the distance does not
 * err: H grows with the hold at the rate of the bound. */
static double step_of_hold(const Point *at) {
    double p = at->profile.p, h = at->slope, c = -at->error / (1.0 - p / at->profile.q);
    double root = square_root(larger(h * h + 2.0 * p * c, 0.0));
    return h > 0.0 ? 2.0 * c / (h + root) : (root - h) / p;
}

/* Take what the distance errs from the time at a bound so small that the velocity does not feel it:
 * the parameter is coarser than such a time. */
static jounce_profile with_time_mended(const jounce_family *f, jounce_profile profile) {
    double error, time, hold, dwell, gained, lost, change, most;
    int rear, is_hold;
    Travel there;
    Ends e;
    if (profile.hold + profile.dwell == 0.0) {
        return profile;
    }
    there = travel(f, &profile);
    error = there.distance - f->task.distance;
    if (magnitude(error) <= EPSILON * there.scale && !f->ahead.uneven) {
        return profile;
    }
    e = ends_of_fall(f, &profile);
    time = profile.fall * f->fall_time;
    rear = e.fastest[1] < e.fastest[0];
    hold = -error / (rear ? e.v : e.v + profile.p * time);
    dwell = -error / (rear ? e.w - profile.q * time : e.w);
    gained = magnitude(profile.p * hold);
    lost = magnitude(profile.q * dwell);
    is_hold = profile.hold > 0.0 && !(profile.dwell > 0.0 && lost < gained);
    change = is_hold ? hold : dwell;
    most = is_hold ? profile.hold : profile.dwell;
    if (!((is_hold ? gained : lost) <= 4.0 * EPSILON * larger(e.fastest[0], e.fastest[1])) ||
        most <= magnitude(change)) {
        return profile;
    }
    if (is_hold) {
        profile.hold += change;
    } else {
        profile.dwell += change;
    }
    profile.duration += change;
    return profile;
}

/* The profile between two points at which the distance errs either way, `other` being the parameter
 * of the second, from a guess on: Newton's iteration, which ends where the curvature seen tells that
 * its next step leaves nothing but rounding. */
static jounce_profile polished(const jounce_family *f, const Arc *arc, const Point *first,
                               double other, double guess) {
    int kind = arc->kind, i;
    double low = smaller(first->s, other), high = larger(first->s, other);
    double following = clamp(guess, low, high), moved = following - first->s;
    double steep_before = steepness(f, kind, first);
    int low_is_short = (first->error < 0.0) == (first->s < other);
    Point at;
    for (i = 0; i < MOST_STEPS; i++) {
        double steep;
        at.s = following;
        at.profile = member(f, arc, following);
        measure(f, &at);
        if (magnitude(at.error) <= EPSILON * at.scale) {
            return f->ahead.uneven ? with_time_mended(f, at.profile) : at.profile;
        }
        if ((at.error < 0.0) == low_is_short) {
            low = at.s;
        } else {
            high = at.s;
        }
        steep = steepness(f, kind, &at);
        following = steep != 0.0 ? at.s - at.error / steep : low;
        if (!(low < following && following < high)) {
            following = 0.5 * (low + high);
            if (following == low || following == high) {
                break;
            }
        } else if (i > 0 || kind == BOTH) {
            double step = following - at.s, bend = (steep - steep_before) * step * step;
            if (magnitude(bend) <= EPSILON * at.scale * magnitude(moved)) {
                at.profile = member(f, arc, following);
                break;
            }
        }
        moved = following - at.s;
        steep_before = steep;
        if (moved == 0.0) {
            break;
        }
    }
    return with_time_mended(f, at.profile);
}

/* The profile between two points at which the distance errs either way. Where both bounds are held
 * the distance is a quadratic of the parameter. */
static jounce_profile between(const jounce_family *f, const Arc *arc, const Point *first,
                              const Point *last) {
    double step;
    if (arc->kind == BOTH) {
        step = step_of_hold(first);
    } else {
        step = step_to_zero(last->s - first->s, first->error, steepness(f, arc->kind, first),
                            last->error, steepness(f, arc->kind, last));
    }
    return polished(f, arc, first, last->s, first->s + step);
}

/* Put the turning points inside an arc between its ends; returns the number of all marks. Where the
 * acceleration crosses zero H grows with the duration, so that one that begins positive stays so. */
static int marks_of(const jounce_family *f, const Arc *arc, const Point *first, double *marks) {
    double low = smaller(arc->first, arc->last), high = larger(arc->first, arc->last);
    double turns[2];
    int n = 0, count = 1, i;
    if (first->slope < 0.0 || first->profile.p < 0.0 || first->profile.q > 0.0) {
        n = turning_points(f, arc, turns);
    }
    marks[0] = arc->first;
    for (i = 0; i < n; i++) {
        if (low < turns[i] && turns[i] < high) {
            marks[count++] = turns[i];
        }
    }
    if (count == 3 && (marks[1] > marks[2]) == (arc->first < arc->last)) {
        double turn = marks[1];
        marks[1] = marks[2];
        marks[2] = turn;
    }
    marks[count++] = arc->last;
    return count;
}

/* Whether two profiles are one but for rounding: the last of an arc and the first of another. */
static inline int are_same(const jounce_profile *a, const jounce_profile *b) {
    double slack = EPSILON * b->duration;
    return a->duration >= 0.0 && magnitude(a->p - b->p) <= EPSILON * magnitude(b->p) &&
           magnitude(a->q - b->q) <= EPSILON * magnitude(b->q) &&
           magnitude(a->hold - b->hold) <= slack && magnitude(a->dwell - b->dwell) <= slack;
}

/* The first point of an arc, of which the profile is given; `last` is that of the arc before. */
static Point first_point(const jounce_family *f, const Arc *arc, const jounce_profile *profile,
                         const Point *last) {
    Point at = *last;
    at.profile = *profile;
    at.s = arc->first;
    if (!are_same(&last->profile, profile)) {
        measure(f, &at);
    }
    return at;
}

/* Keep a profile that errs by what rounding of the state may be worth: it stands unless one that does
 * not err takes hardly longer. */
static void keep_nearly(const Point *at, jounce_profiles *found) {
    jounce_profile profile = at->profile;
    profile.worth = at->slope != 0.0 ? magnitude(2.0 * at->error / at->slope) : INFINITE;
    profile.worth = smaller(profile.worth, HARDLY);
    keep(&profile, found);
}

/* Keep the profile at a point, or between it and the point before. */
static void keep_up_to(const jounce_family *f, const Arc *arc, const Point *before, Point *at,
                       jounce_profiles *found) {
    double exact = f->rounding + 4.0 * ROUNDING * at->scale;
    if (magnitude(at->error) <= exact) {
        keep(&at->profile, found);
        at->error = 0.0;
    } else if (is_blur(f, at->error, exact, at->profile.duration)) {
        keep_nearly(at, found);
    }
    if (before->error * at->error < 0.0) {
        jounce_profile profile = between(f, arc, before, at);
        keep(&profile, found);
    }
}

/* Keep the profiles of an arc of which the first member is given. `last` is that of the arc before,
 * and becomes that of this one. */
static void on_arc(const jounce_family *f, const Arc *arc, const jounce_profile *first,
                   Point *last, jounce_profiles *found) {
    double marks[4];
    Point points[2];
    int count, i;
    points[0] = first_point(f, arc, first, last);
    keep_up_to(f, arc, &points[0], &points[0], found);
    count = marks_of(f, arc, &points[0], marks);
    for (i = 1; i < count; i++) {
        Point *at = &points[i % 2], *before = &points[(i + 1) % 2];
        at->s = marks[i];
        if (!is_finite(at->s) && !far_parameter(f, arc, before->s, at->s, &at->s)) {
            return;
        }
        at->profile = member(f, arc, at->s);
        measure(f, at);
        keep_up_to(f, arc, before, at, found);
    }
    *last = points[(count - 1) % 2];
}

/* The rise to the peak, and the hold there, of a profile that reaches v_max with zero acceleration,
 * seen in a view from velocity v. */
static void rise_to_cruise(const jounce_family *f, const jounce_view *t, double v,
                           jounce_profile *profile) {
    double p = t->top, gained;
    profile->p = t->p_cruise.size;
    profile->first = t->p_cruise.beyond;
    profile->hold = 0.0;
    if (profile->p > p) {
        profile->p = p;
        profile->first = p - t->a0;
        gained = profile->first * (p + t->a0) * f->half_rise + p * p * f->half_fall;
        profile->hold = larger(f->task.v_max - v - gained, 0.0) / p;
    }
}

/* The profile that touches v_max with zero acceleration. */
static int cruising(const jounce_family *f, jounce_profile *profile) {
    const jounce_task *t = &f->task;
    double p = f->ahead.p_cruise.size, q = f->ahead.q_cruise.size;
    jounce_profile last = {0};
    if (!(f->ahead.may_dip && f->ahead.may_rise && p >= 0.0 && is_finite(p) && is_finite(q) &&
          q >= 0.0) ||
        is_empty(f)) {
        return 0;
    }
    *profile = last;
    rise_to_cruise(f, &f->ahead, t->v0, profile);
    rise_to_cruise(f, &f->back, t->v1, &last);
    profile->q = -last.p;
    profile->last = last.first;
    profile->dwell = last.hold;
    profile->fall = profile->p - profile->q;
    set_duration(f, profile);
    return 1;
}

static void cruise_for(const jounce_family *f, double distance, jounce_profile *profile) {
    profile->cruise = larger(distance, 0.0) / f->task.v_max;
    profile->duration += profile->cruise;
}

/* The profile that touches v_max, or cruises there; 0 where it does not cover the distance, or takes
 * as long as is allowed. */
static int cruising_there(const jounce_family *f, double longest, jounce_profile *profile) {
    double v_max = f->task.v_max, rest, allowed;
    int is_there;
    if (!cruising(f, profile) || profile->duration >= longest) {
        return 0;
    }
    rest = f->task.distance - travel(f, profile).distance;
    allowed = 4.0 * ROUNDING * magnitude(v_max) * profile->duration;
    is_there = is_blur(f, rest, allowed, profile->duration);
    if (v_max > 0.0) {
        cruise_for(f, rest, profile);
    }
    return is_there || (v_max > 0.0 && rest >= 0.0);
}

/* Sort arcs by the durations with which they begin. */
static void sort_arcs(const jounce_family *f, const Arcs *arcs, jounce_profile *firsts, int *sorted) {
    int i, k;
    for (i = 0; i < arcs->count; i++) {
        firsts[i] = member(f, &arcs->arcs[i], arcs->arcs[i].first);
        for (k = i; k > 0 && firsts[sorted[k - 1]].duration > firsts[i].duration; k--) {
            sorted[k] = sorted[k - 1];
        }
        sorted[k] = i;
    }
}

/* Whether one profile at most covers the task's distance, which lies beyond that with which the
 * family begins. It grows with the duration where an end keeps the velocity, and with it H, positive,
 * and it is convex where the acceleration crosses zero. Profiles that begin or end with braking, from
 * a0 < 0 or to a1 > 0, come first: with H at most the velocity there, which the family leaves behind
 * within the time of two ramps. */
static int is_single(const jounce_family *f, double begins) {
    const jounce_task *t = &f->task;
    double ahead = t->distance - begins;
    double braking = f->ratio >= 0.0 ? larger(t->v1, 0.0) * larger(t->a1, 0.0)
                                     : larger(t->v0, 0.0) * larger(-t->a0, 0.0);
    int grows = (t->a0 >= 0.0 && t->v0 >= 0.0) || (t->a1 <= 0.0 && t->v1 >= 0.0);
    return ahead > HARDLY && (grows || ahead > braking * (f->rise_time + f->fall_time)) &&
           t->a0 * t->a1 <= 0.0 && t->v_max > 0.0 && !is_empty(f);
}

/* Where the distance of a task lies, seen from an arc or a cruise. */
typedef enum { LIES_BEFORE, LIES_ON, LIES_BEYOND, LIES_OPEN } Side;

static Side side_of(double error, double noise) {
    return error > noise ? LIES_BEFORE : error < -noise ? LIES_BEYOND : LIES_OPEN;
}

/* The single profile, where it is on this arc or beyond. */
static Side single_on(const jounce_family *f, const Arc *arc, jounce_profiles *found) {
    Point at;
    Side side;
    at.profile = member(f, arc, arc->first);
    measure(f, &at);
    side = side_of(at.error, 4.0 * ROUNDING * at.scale + most_blur(f, at.profile.duration));
    if (side != LIES_BEYOND) {
        return side;
    }
    on_arc(f, arc, &at.profile, &at, found);
    return found->count == 1 && found->profiles[0].worth == 0.0 ? LIES_ON : LIES_OPEN;
}

/* The single profile, where it holds both bounds as does `touch`, which reaches v_max and goes too
 * far; what rounding of that profile leaves open is not told. */
static Side single_holding_both(const jounce_family *f, const Point *touch, jounce_profile *best) {
    const jounce_profile *t = &touch->profile;
    Arc arc = {BOTH, 0.0, 0.0, 0.0};
    double least, guess;
    Side side;
    if (!(t->hold > 0.0 && t->dwell > 0.0)) {
        return LIES_BEFORE;
    }
    least = larger(t->hold + t->dwell * t->q / t->p, 0.0);
    guess = touch->s + step_of_hold(touch);
    side = side_of(least - guess, HARDLY * touch->s);
    if (side == LIES_BEYOND) {
        *best = polished(f, &arc, touch, least, guess);
        return LIES_ON;
    }
    return side;
}

/* The single profile, where it is on the arc on which both bounds are held, or before. */
static Side single_on_longest(const jounce_family *f, Arcs *arcs, jounce_profiles *found) {
    arcs->count = 0;
    find_longest(f, arcs);
    return arcs->count > 0 ? single_on(f, &arcs->arcs[0], found) : LIES_BEFORE;
}

/* The single profile, where it holds one bound at most. */
static Side single_on_shorter(const jounce_family *f, Arcs *arcs, jounce_profiles *found) {
    Side side = LIES_BEFORE;
    arcs->count = 0;
    find_shorter(f, arcs);
    while (side == LIES_BEFORE && arcs->count > 0) {
        side = single_on(f, &arcs->arcs[--arcs->count], found);
    }
    return side;
}

/* The single profile, sought from the longest on; 0 where rounding leaves it open. */
static int jerk_single(const jounce_family *f, Arcs *arcs, jounce_profiles *found,
                       jounce_profile *best) {
    Side side = LIES_OPEN;
    Point touch;
    if (cruising(f, &touch.profile)) {
        touch.s = touch.profile.hold;
        measure(f, &touch);
        side = side_of(touch.error, 4.0 * ROUNDING * f->task.v_max * touch.profile.duration +
                                        most_blur(f, touch.profile.duration));
        if (side == LIES_BEYOND) {
            *best = touch.profile;
            cruise_for(f, -touch.error, best);
            return 1;
        }
        if (side == LIES_BEFORE) {
            side = single_holding_both(f, &touch, best);
            if (side == LIES_ON) {
                return 1;
            }
        }
    }
    if (side == LIES_OPEN) {
        side = single_on_longest(f, arcs, found);
    }
    if (side == LIES_BEFORE) {
        side = single_on_shorter(f, arcs, found);
    }
    if (side == LIES_ON) {
        *best = found->profiles[0];
    }
    return side == LIES_ON;
}

/* The durations grow along an arc, so that once a profile is found no arc that begins later holds
 * a shorter one. */
int jounce_jerk_shortest(const jounce_family *f, double begins, jounce_profile *best) {
    jounce_profile firsts[MOST_ARCS];
    double shortest = INFINITE;
    jounce_profiles found;
    Point last;
    Arcs arcs;
    int sorted[MOST_ARCS], i, seen = 0, at = -1;
    found.count = 0;
    if (is_single(f, begins) && jerk_single(f, &arcs, &found, best)) {
        return 1;
    }
    last.profile.duration = -1.0; /* of no arc */
    found.count = 0;
    find_arcs(f, &arcs);
    sort_arcs(f, &arcs, firsts, sorted);
    for (i = 0; i < arcs.count; i++) {
        const jounce_profile *first = &firsts[sorted[i]];
        if (first->duration >= shortest) {
            break;
        }
        on_arc(f, &arcs.arcs[sorted[i]], first, &last, &found);
        for (; seen < found.count; seen++) {
            const jounce_profile *profile = &found.profiles[seen];
            if (profile->duration + profile->worth < shortest) {
                shortest = profile->duration + profile->worth;
                at = seen;
            }
        }
    }
    if (cruising_there(f, shortest, best) && best->duration < shortest) {
        return 1;
    }
    if (at >= 0) {
        *best = found.profiles[at];
    }
    return at >= 0;
}

/* Drop profiles that err where one that takes hardly longer does not. */
static void drop_outdone(jounce_profiles *found) {
    int i, k, kept = 0;
    for (i = 0; i < found->count; i++) {
        jounce_profile profile = found->profiles[i];
        int stands = 1;
        for (k = 0; k < found->count && profile.worth > 0.0; k++) {
            const jounce_profile *other = &found->profiles[k];
            if (other->worth == 0.0 && profile.duration <= other->duration &&
                other->duration <= profile.duration + profile.worth) {
                stands = 0;
            }
        }
        if (stands) {
            found->profiles[kept++] = profile;
        }
    }
    found->count = kept;
}

void jounce_jerk_solutions(const jounce_family *f, jounce_profiles *found) {
    jounce_profile profile;
    Point last;
    Arcs arcs;
    int i;
    last.profile.duration = -1.0; /* of no arc */
    found->count = 0;
    find_arcs(f, &arcs);
    for (i = 0; i < arcs.count; i++) {
        profile = member(f, &arcs.arcs[i], arcs.arcs[i].first);
        on_arc(f, &arcs.arcs[i], &profile, &last, found);
    }
    if (cruising_there(f, INFINITE, &profile)) {
        keep(&profile, found);
    }
    drop_outdone(found);
}

/* --- profiles of a given duration --------------------------------------------------------------- */

/* The parameter of a duration, `more` than that of the arc's first member. */
static double parameter(const jounce_family *f, const Arc *arc, const jounce_profile *first,
                        double more) {
    double step = 0.5 * more * f->per_kappa, fall = first->fall, sum = fall + step, bend = 0.0;
    switch (arc->kind) {
    case FREE_Q: /* the duration is 2 kappa (p - q) and a constant */
    case FREE_P:
        if (fall > 0.0) {
            bend = magnitude(f->ratio) / sum / fall;
        }
        return arc->first + (arc->kind == FREE_Q ? -0.5 : 0.5) * step * (1.0 + bend);
    case HOLD: /* the duration is kappa (q - p)^2 / p and a constant */
    case DWELL:
        step = more * (arc->kind == HOLD ? first->p : -first->q) * f->per_kappa;
        sum = fall + square_root(fall * fall + step);
        step = sum > 0.0 ? step / sum : 0.0;
        return arc->first + (arc->kind == HOLD ? -step : step);
    default:
        return arc->first + more / (1.0 - first->p / first->q);
    }
}

static int lasting_on(const jounce_family *f, const Arc *arc, double duration,
                      jounce_profile *profile) {
    jounce_profile shortest = member(f, arc, arc->first);
    double s;
    if (duration < shortest.duration * (1.0 - ROUNDING)) {
        return 0;
    }
    if (is_finite(arc->last)) {
        jounce_profile longest = member(f, arc, arc->last);
        if (duration >= longest.duration) {
            *profile = longest;
            return duration <= longest.duration * (1.0 + ROUNDING);
        }
    }
    s = parameter(f, arc, &shortest, larger(duration - shortest.duration, 0.0));
    s = clamp(s, smaller(arc->first, arc->last), larger(arc->first, arc->last));
    *profile = member(f, arc, s);
    return 1;
}

int jounce_jerk_lasting(const jounce_family *f, double duration, jounce_profile *profile) {
    Arcs arcs;
    int i;
    find_arcs(f, &arcs);
    for (i = 0; i < arcs.count; i++) {
        if (lasting_on(f, &arcs.arcs[i], duration, profile)) {
            return 1;
        }
    }
    if (!cruising(f, profile) || profile->duration > duration * (1.0 + ROUNDING)) {
        return 0;
    }
    profile->cruise = larger(duration - profile->duration, 0.0);
    profile->duration += profile->cruise;
    return 1;
}

int jounce_jerk_edges(const jounce_family *f, double *durations) {
    jounce_profile profile;
    Arcs arcs;
    int i, count = 0;
    find_arcs(f, &arcs);
    for (i = 0; i < arcs.count; i++) {
        durations[count++] = member(f, &arcs.arcs[i], arcs.arcs[i].first).duration;
        if (is_finite(arcs.arcs[i].last)) {
            durations[count++] = member(f, &arcs.arcs[i], arcs.arcs[i].last).duration;
        }
    }
    if (cruising(f, &profile)) {
        durations[count++] = profile.duration;
    }
    return count;
}

double jounce_jerk_distance(const jounce_family *f, const jounce_profile *profile) {
    double distance = travel(f, profile).distance;
    return profile->cruise > 0.0 ? distance + f->task.v_max * profile->cruise : distance;
}

int jounce_jerk_lengths(const jounce_family *f, const jounce_profile *profile, double *lengths) {
    int count = 0;
    lengths[count++] = profile->first * f->rise_time;
    lengths[count++] = profile->hold;
    if (profile->cruise > 0.0) {
        lengths[count++] = profile->p * f->fall_time;
        lengths[count++] = profile->cruise;
        lengths[count++] = -profile->q * f->fall_time;
    } else {
        lengths[count++] = profile->fall * f->fall_time;
    }
    lengths[count++] = profile->dwell;
    lengths[count++] = profile->last * f->rise_time;
    return count;
}

/* The first pieces are reckoned from the start, those after the fall from the end: rounding meets
 * before the fall or after it. */
void jounce_jerk_pieces(const jounce_family *f, const jounce_profile *profile, double start,
                        double end, jounce_motion *motion) {
    const jounce_task *t = &f->task;
    double p = profile->p, q = profile->q, hold = profile->hold, dwell = profile->dwell;
    double lengths[JOUNCE_MOST_LENGTHS], *last;
    double v = t->v0, x = start, w = t->v1, y = end;
    Ends e = ends_of_fall(f, profile);
    last = lengths + jounce_jerk_lengths(f, profile, lengths) - 1;
    jounce_add(motion, lengths[0], x, v, t->a0, t->rise);
    x += ramp_in(&v, t->a0, p, lengths[0]);
    jounce_add(motion, hold, x, v, p, 0.0);
    x = start + e.x;
    y = end - e.y;
    if (profile->cruise > 0.0) {
        double top = t->v_max, before = e.v, back = top;
        jounce_add(motion, lengths[2], x, e.v, p, -t->fall);
        x += ramp_in(&before, p, 0.0, lengths[2]);
        jounce_add(motion, lengths[3], x, top, 0.0, 0.0);
        jounce_add(motion, lengths[4], y - ramp_in(&back, 0.0, q, lengths[4]), top, 0.0, -t->fall);
    } else if (e.fastest[1] < e.fastest[0]) {
        double before = e.w;
        x = y + ramp_in(&before, q, p, -lengths[2]);
        jounce_add(motion, lengths[2], x, before, p, -t->fall);
    } else {
        jounce_add(motion, lengths[2], x, e.v, p, -t->fall);
    }
    jounce_add(motion, dwell, y, e.w, q, 0.0);
    y = end + ramp_in(&w, t->a1, q, -*last);
    jounce_add(motion, *last, y, w, q, t->rise);
}
