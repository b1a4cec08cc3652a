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

/* One structure of a family, over a range of its parameter in which the duration grows. */
typedef struct {
    int kind;
    double first, last;
} Arc;

enum { MOST_ARCS = 12, MOST_STEPS = 2200 }; /* steps: of a root 300 decades below its bracket */

typedef struct {
    int count;
    Arc arcs[MOST_ARCS];
} Arcs;

#define HARDLY 1e-6 /* a time that does not count beside those of order one */

/* --- what depends on the task alone ------------------------------------------------------------ */

static double slack_of(const jounce_family *f, double bound) {
    return ROUNDING * magnitude(bound) + f->noise;
}

/* The root of a squared acceleration, rounding about zero taken for zero. */
static double root_of(const jounce_family *f, double square) {
    return square * f->kappa > f->noise ? square_root(square) : 0.0;
}

/* The acceleration that gains the speed, -infinity where it is below the least. */
static double to_cruise(const jounce_family *f, double gain, double least) {
    double square;
    if (!is_finite(gain)) {
        return INFINITE;
    }
    square = gain * f->per_kappa;
    if (square > least * least) {
        return square_root(square);
    }
    return square >= least * least - slack_of(f, f->task.v_max) * f->per_kappa ? least : -INFINITE;
}

void jounce_jerk_family(const jounce_task *task, jounce_family *f) {
    const jounce_task *t = &f->task;
    double squares = larger(task->a0 * task->a0, task->a1 * task->a1), lowest;
    double speed = larger(magnitude(task->v0), magnitude(task->v1));
    double jerk = smaller(task->rise, task->fall), stop;
    f->task = *task;
    stop = speed / smaller(t->a_max, -t->a_min) + square_root(speed / jerk) +
           larger(magnitude(t->a0), magnitude(t->a1)) / jerk;
    f->rounding = t->resolution + ROUNDING * magnitude(t->distance);
    f->blur = f->rounding + ROUNDING * speed * stop;
    f->rise_time = 1.0 / t->rise;
    f->fall_time = 1.0 / t->fall;
    f->kappa = 0.5 * f->rise_time + 0.5 * f->fall_time;
    f->per_kappa = 1.0 / f->kappa;
    f->noise = ROUNDING * (speed + f->kappa * squares);
    f->c = t->v1 - t->v0 + (t->a0 - t->a1) * (t->a0 + t->a1) * 0.5 * f->rise_time;
    if (magnitude(f->c) <= f->noise) {
        f->c = 0.0;
    }
    f->ratio = f->c * f->per_kappa;
    f->v_in = t->v0 - t->a0 * t->a0 * 0.5 * f->rise_time;
    f->v_out = t->v1 - t->a1 * t->a1 * 0.5 * f->rise_time;
    f->p_cruise = to_cruise(f, t->v_max - f->v_in, larger(t->a0, 0.0));
    f->q_cruise = -to_cruise(f, t->v_max - f->v_out, larger(-t->a1, 0.0));
    lowest = t->v_min - slack_of(f, t->v_min);
    /* a rise at the end that starts below zero acceleration dips to v_out, and so does one at the
     * start that ends above it to v_in */
    f->may_dip = t->a1 <= 0.0 || f->v_out >= lowest;
    f->may_rise = t->a0 >= 0.0 || f->v_in >= lowest;
}

/* --- the arcs ---------------------------------------------------------------------------------- */

static void add_arc(Arcs *arcs, int kind, double first, double last) {
    if (arcs->count < MOST_ARCS) {
        Arc arc = {kind, first, last};
        arcs->arcs[arcs->count++] = arc;
    }
}

/* The two arcs in falling q: from `start` to `least`, and from -low to -high. */
static void add_in_q(const jounce_family *f, int kind, double low, double high, double start,
                     double least, Arcs *arcs) {
    double bottom = 0.0;
    if (!f->may_rise) {
        return;
    }
    if (f->may_dip) {
        bottom = larger(larger(f->task.a_min, f->q_cruise), -high);
    }
    if (least <= start) {
        if (least == 0.0 && bottom < 0.0) {
            add_arc(arcs, kind, start, bottom);
            return;
        }
        add_arc(arcs, kind, start, least);
    }
    if (bottom <= -low) {
        add_arc(arcs, kind, -low, bottom);
    }
}

/* The two arcs in rising p: from `start` to -least, and from `low` to `high`. */
static void add_in_p(const jounce_family *f, int kind, double low, double high, double start,
                     double least, Arcs *arcs) {
    double top = 0.0;
    if (!f->may_dip) {
        return;
    }
    if (f->may_rise) {
        top = smaller(smaller(f->task.a_max, f->p_cruise), high);
    }
    if (start <= -least) {
        if (least == 0.0 && top > 0.0) {
            add_arc(arcs, kind, start, top);
            return;
        }
        add_arc(arcs, kind, start, -least);
    }
    if (low <= top) {
        add_arc(arcs, kind, low, top);
    }
}

static double root_or_none(const jounce_family *f, double square) {
    return square * f->kappa >= -f->noise ? root_of(f, square) : -INFINITE;
}

static void add_holds(const jounce_family *f, Arcs *arcs) {
    double p = f->task.a_max, q = f->task.a_min;
    double first = larger(f->c - f->kappa * (p * p - q * q), 0.0) / p;
    double last = (f->task.v_max - f->v_in - f->kappa * p * p) / p;
    if (first <= last) {
        add_arc(arcs, BOTH, first, last);
    }
}

/* The arcs of the family without cruise. */
static void find_arcs(const jounce_family *f, Arcs *arcs) {
    const jounce_task *t = &f->task;
    double a0 = t->a0, a1 = t->a1, p_max = t->a_max, q_min = t->a_min, ratio = f->ratio;
    double least, most;
    arcs->count = 0;
    if (a0 > p_max || a1 < q_min) {
        return;
    }
    if (ratio == 0.0 && a0 <= a1 && a1 < 0.0) {
        add_arc(arcs, FREE_P, a1, a1); /* nothing but the rise */
    }
    if (ratio >= 0.0) {
        least = a0 > 0.0 ? root_of(f, a0 * a0 - ratio) : 0.0;
        most = is_finite(p_max) ? root_or_none(f, p_max * p_max - ratio) : INFINITE;
        add_in_q(f, FREE_Q, larger(least, -a1), most, smaller(a1, most), least, arcs);
    } else {
        least = a1 < 0.0 ? root_of(f, a1 * a1 + ratio) : 0.0;
        most = is_finite(q_min) ? root_or_none(f, q_min * q_min + ratio) : INFINITE;
        add_in_p(f, FREE_P, larger(least, a0), most, larger(a0, -most), least, arcs);
    }
    if (is_finite(p_max)) {
        least = root_of(f, p_max * p_max - ratio);
        add_in_q(f, HOLD, larger(least, -a1), -q_min, smaller(a1, p_max), least, arcs);
    }
    if (is_finite(q_min)) {
        least = root_of(f, q_min * q_min + ratio);
        add_in_p(f, DWELL, larger(least, a0), p_max, larger(a0, q_min), least, arcs);
    }
    if (is_finite(p_max) && is_finite(q_min) && f->may_dip && f->may_rise) {
        add_holds(f, arcs);
    }
}

static inline jounce_profile timed(const jounce_family *f, double p, double hold, double q,
                            double dwell) {
    const jounce_task *t = &f->task;
    double moving = ((p - t->a0) + (t->a1 - q)) * f->rise_time + (p - q) * f->fall_time;
    jounce_profile profile = {larger(moving, 0.0) + hold + dwell, p, hold, 0.0, q, dwell, 0.0};
    return profile;
}

/* The member of an arc at parameter s. */
static inline jounce_profile member(const jounce_family *f, int kind, double s) {
    const jounce_task *t = &f->task;
    double p = t->a_max, q = t->a_min, hold = 0.0, dwell = 0.0;
    switch (kind) {
    case FREE_Q:
        p = larger(square_root(larger(f->ratio + s * s, 0.0)), t->a0);
        q = s;
        break;
    case FREE_P:
        p = s;
        q = smaller(-square_root(larger(s * s - f->ratio, 0.0)), t->a1);
        break;
    case HOLD:
        q = s;
        hold = larger((f->c - f->kappa * (p - q) * (p + q)) / p, 0.0);
        break;
    case DWELL:
        p = s;
        dwell = larger((f->c - f->kappa * (p - q) * (p + q)) / q, 0.0);
        break;
    default:
        hold = s;
        dwell = larger((f->c - f->kappa * (p * p - q * q) - p * hold) / q, 0.0);
    }
    return timed(f, p, hold, q, dwell);
}

/* The derivative of the duration by the parameter. */
static inline double duration_slope(const jounce_family *f, int kind, const jounce_profile *profile) {
    double p = profile->p, q = profile->q;
    switch (kind) {
    case FREE_Q:
    case HOLD:
        return p != 0.0 ? 2.0 * f->kappa * (q / p - 1.0) : -2.0 * f->kappa;
    case FREE_P:
    case DWELL:
        return q != 0.0 ? 2.0 * f->kappa * (1.0 - p / q) : 2.0 * f->kappa;
    default:
        return 1.0 - p / q;
    }
}

/* --- distance ---------------------------------------------------------------------------------- */

typedef struct {
    double distance, slope, scale; /* without the cruise; its derivative by the duration; rounding */
} Travel;

static inline Travel travel(const jounce_family *f, const jounce_profile *profile) {
    const jounce_task *t = &f->task;
    double p = profile->p, q = profile->q, v = t->v0, w, x, fastest;
    Travel result;
    x = ramp_in(&v, t->a0, p, (p - t->a0) * f->rise_time);
    x += (v + 0.5 * p * profile->hold) * profile->hold;
    v += p * profile->hold;
    result.slope = v + 0.5 * p * (p - q) * f->fall_time;
    w = v;
    x += ramp_in(&w, p, q, (p - q) * f->fall_time);
    x += (w + 0.5 * q * profile->dwell) * profile->dwell;
    fastest = larger(larger(magnitude(t->v0), magnitude(v)), larger(magnitude(w), magnitude(t->v1)));
    w += q * profile->dwell;
    x += ramp_in(&w, q, t->a1, (t->a1 - q) * f->rise_time);
    result.distance = x;
    result.scale = fastest * profile->duration;
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
static int turning_points(const jounce_family *f, int kind, double *points) {
    const jounce_task *t = &f->task;
    double p = t->a_max, q = t->a_min;
    if (kind == FREE_Q || kind == FREE_P) {
        double alpha = 0.125 * f->rise_time + 0.25 * f->fall_time, roots[2];
        double gamma = f->v_in + 0.25 * f->ratio * (f->rise_time + f->fall_time);
        double beta = 0.125 * f->ratio * f->ratio * f->rise_time;
        int n = quadratic(alpha, gamma, beta, roots), i, count = 0;
        for (i = 0; i < n; i++) {
            if (roots[i] > 0.0) {
                double w = square_root(roots[i]);
                points[count++] = (kind == FREE_Q ? -0.5 : 0.5) * w + 0.5 * f->ratio / w;
            }
        }
        return count;
    }
    if (kind == HOLD) {
        return quadratic(f->kappa, -0.5 * p * f->fall_time, f->v_in + f->c, points);
    }
    if (kind == DWELL) {
        return quadratic(f->kappa, -0.5 * q * f->fall_time, f->v_in, points);
    }
    points[0] = -(f->v_in + 0.5 * p * p * f->rise_time + 0.5 * p * (p - q) * f->fall_time) / p;
    return 1;
}

/* --- profiles of a given distance --------------------------------------------------------------- */

static void keep(const jounce_profile *profile, jounce_profiles *found) {
    if (found->count < JOUNCE_MOST_PROFILES) {
        found->profiles[found->count++] = *profile;
    }
}

/* A parameter beyond which the distance wanted is exceeded for good; 0 where there is none. */
static int far_parameter(const jounce_family *f, int kind, double s, double infinite, double *far) {
    double step = infinite > 0.0 ? 1.0 : -1.0;
    while (magnitude(step) < 1e100) {
        jounce_profile profile = member(f, kind, s + step);
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

/* How far a quadratic goes to zero, which is `error` with derivative `slope` here and has the other
 * sign a `step` away. */
static inline double quadratic_step(double step, double error, double slope, double other_error) {
    double rise = (other_error - error) / step, bend = (rise - slope) / step;
    double root = square_root(larger(slope * slope - 4.0 * bend * error, 0.0));
    return -2.0 * error / (slope + (rise > 0.0 ? root : -root));
}

/* The profile between two points at which the distance errs either way: Newton's iteration, which
 * ends where the curvature seen tells that its next step leaves nothing but rounding. Where both
 * bounds are held the distance is a quadratic of the parameter. */
static jounce_profile between(const jounce_family *f, int kind, const Point *first,
                              const Point *last) {
    double low = smaller(first->s, last->s), high = larger(first->s, last->s);
    double step = last->s - first->s, steep_before = steepness(f, kind, first), moved;
    int low_is_short = (first->error < 0.0) == (first->s < last->s), i;
    double following =
        first->s + (kind == BOTH ? quadratic_step(step, first->error, steep_before, last->error)
                                 : step_to_zero(step, first->error, steep_before, last->error,
                                                steepness(f, kind, last)));
    Point at;
    following = clamp(following, low, high);
    moved = following - first->s;
    for (i = 0; i < MOST_STEPS; i++) {
        double steep;
        at.s = following;
        at.profile = member(f, kind, following);
        measure(f, &at);
        if (magnitude(at.error) <= EPSILON * at.scale) {
            break;
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
            double bend;
            step = following - at.s;
            bend = (steep - steep_before) * step * step;
            if (magnitude(bend) <= EPSILON * at.scale * magnitude(moved)) {
                return member(f, kind, following);
            }
        }
        moved = following - at.s;
        steep_before = steep;
        if (moved == 0.0) {
            break;
        }
    }
    return at.profile;
}

/* Put the turning points inside an arc between its ends; returns the number of all marks. Where the
 * acceleration crosses zero H grows with the duration, so that one that begins positive stays so. */
static int marks_of(const jounce_family *f, const Arc *arc, const Point *first, double *marks) {
    double low = smaller(arc->first, arc->last), high = larger(arc->first, arc->last);
    double turns[2];
    int n = 0, count = 1, i;
    if (first->slope < 0.0 || first->profile.p < 0.0 || first->profile.q > 0.0) {
        n = turning_points(f, arc->kind, turns);
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
static void keep_up_to(const jounce_family *f, int kind, const Point *before, Point *at,
                       jounce_profiles *found) {
    double exact = f->rounding + 4.0 * ROUNDING * at->scale;
    if (magnitude(at->error) <= exact) {
        keep(&at->profile, found);
        at->error = 0.0;
    } else if (magnitude(at->error) <= exact + f->blur) {
        keep_nearly(at, found);
    }
    if (before->error * at->error < 0.0) {
        jounce_profile profile = between(f, kind, before, at);
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
    keep_up_to(f, arc->kind, &points[0], &points[0], found);
    count = marks_of(f, arc, &points[0], marks);
    for (i = 1; i < count; i++) {
        Point *at = &points[i % 2], *before = &points[(i + 1) % 2];
        at->s = marks[i];
        if (!is_finite(at->s) && !far_parameter(f, arc->kind, before->s, at->s, &at->s)) {
            return;
        }
        at->profile = member(f, arc->kind, at->s);
        measure(f, at);
        keep_up_to(f, arc->kind, before, at, found);
    }
    *last = points[(count - 1) % 2];
}

/* The profile that touches v_max with zero acceleration. */
static int cruising(const jounce_family *f, jounce_profile *profile) {
    const jounce_task *t = &f->task;
    double p = f->p_cruise, q = f->q_cruise, hold = 0.0, dwell = 0.0;
    if (!(f->may_dip && f->may_rise && p >= 0.0 && is_finite(p) && is_finite(q) && q <= 0.0)) {
        return 0;
    }
    if (t->a0 > t->a_max || t->a1 < t->a_min) {
        return 0;
    }
    if (p > t->a_max) {
        hold = f->kappa * (p / t->a_max - 1.0) * (p + t->a_max);
        p = t->a_max;
    }
    if (q < t->a_min) {
        dwell = f->kappa * (q / t->a_min - 1.0) * (-q - t->a_min);
        q = t->a_min;
    }
    *profile = timed(f, p, hold, q, dwell);
    return 1;
}

/* The profile that touches v_max, or cruises there; 0 where it does not cover the distance, or takes
 * as long as is allowed. */
static int cruising_there(const jounce_family *f, double longest, jounce_profile *profile) {
    double v_max = f->task.v_max, rest, slack;
    if (!cruising(f, profile) || profile->duration >= longest) {
        return 0;
    }
    rest = f->task.distance - travel(f, profile).distance;
    slack = 4.0 * ROUNDING * magnitude(v_max) * profile->duration + f->blur;
    if (v_max <= 0.0) {
        return magnitude(rest) <= slack;
    }
    profile->cruise = larger(rest, 0.0) / v_max;
    profile->duration += profile->cruise;
    return rest >= -slack;
}

/* Sort arcs by the durations with which they begin. */
static void sort_arcs(const jounce_family *f, const Arcs *arcs, jounce_profile *firsts, int *sorted) {
    int i, k;
    for (i = 0; i < arcs->count; i++) {
        firsts[i] = member(f, arcs->arcs[i].kind, arcs->arcs[i].first);
        for (k = i; k > 0 && firsts[sorted[k - 1]].duration > firsts[i].duration; k--) {
            sorted[k] = sorted[k - 1];
        }
        sorted[k] = i;
    }
}

/* The durations grow along an arc, so that once a profile is found no arc that begins later holds
 * a shorter one. */
int jounce_jerk_shortest(const jounce_family *f, jounce_profile *best) {
    jounce_profile firsts[MOST_ARCS];
    double shortest = INFINITE;
    jounce_profiles found;
    Point last;
    Arcs arcs;
    int sorted[MOST_ARCS], i, seen = 0, at = -1;
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
        profile = member(f, arcs.arcs[i].kind, arcs.arcs[i].first);
        on_arc(f, &arcs.arcs[i], &profile, &last, found);
    }
    if (cruising_there(f, INFINITE, &profile)) {
        keep(&profile, found);
    }
    drop_outdone(found);
}

/* --- profiles of a given duration --------------------------------------------------------------- */

/* The parameter of a duration, `more` than that of the arc's first member. */
static double parameter(const jounce_family *f, const Arc *arc, double duration, double more) {
    const jounce_task *t = &f->task;
    double kappa = f->kappa, first = arc->first;
    if (arc->kind == FREE_Q || arc->kind == FREE_P) {
        double width = 0.5 * (duration - (t->a1 - t->a0) / t->rise) / kappa;
        if (width <= 0.0) {
            return first;
        }
        return 0.5 * f->ratio / width + (arc->kind == FREE_Q ? -0.5 : 0.5) * width;
    }
    if (arc->kind == HOLD) { /* the duration is kappa (q - p)^2 / p and a constant */
        double p = t->a_max;
        return p - square_root((first - p) * (first - p) + more * p / kappa);
    }
    if (arc->kind == DWELL) {
        double q = t->a_min;
        return q + square_root((first - q) * (first - q) - more * q / kappa);
    }
    return first + more / (1.0 - t->a_max / t->a_min);
}

static int lasting_on(const jounce_family *f, const Arc *arc, double duration,
                      jounce_profile *profile) {
    jounce_profile shortest = member(f, arc->kind, arc->first);
    double s;
    if (duration < shortest.duration * (1.0 - ROUNDING)) {
        return 0;
    }
    if (is_finite(arc->last)) {
        jounce_profile longest = member(f, arc->kind, arc->last);
        if (duration >= longest.duration) {
            *profile = longest;
            return duration <= longest.duration * (1.0 + ROUNDING);
        }
    }
    s = parameter(f, arc, duration, larger(duration - shortest.duration, 0.0));
    s = clamp(s, smaller(arc->first, arc->last), larger(arc->first, arc->last));
    *profile = member(f, arc->kind, s);
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
        durations[count++] = member(f, arcs.arcs[i].kind, arcs.arcs[i].first).duration;
        if (is_finite(arcs.arcs[i].last)) {
            durations[count++] = member(f, arcs.arcs[i].kind, arcs.arcs[i].last).duration;
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
    const jounce_task *t = &f->task;
    double p = profile->p, q = profile->q;
    int count = 0;
    lengths[count++] = (p - t->a0) / t->rise;
    lengths[count++] = profile->hold;
    if (profile->cruise == 0.0) {
        lengths[count++] = (p - q) / t->fall;
    } else {
        lengths[count++] = p / t->fall;
        lengths[count++] = profile->cruise;
        lengths[count++] = -q / t->fall;
    }
    lengths[count++] = profile->dwell;
    lengths[count++] = (t->a1 - q) / t->rise;
    return count;
}

/* The first pieces are reckoned from the start, those after the fall from the end: rounding meets
 * in between. */
void jounce_jerk_pieces(const jounce_family *f, const jounce_profile *profile, double start,
                        double end, jounce_motion *motion) {
    const jounce_task *t = &f->task;
    double p = profile->p, q = profile->q, hold = profile->hold, dwell = profile->dwell;
    double v = t->v0, x = start, w = t->v1, y = end, w_rear, y_rear;
    double lengths[JOUNCE_MOST_LENGTHS], *last;
    last = lengths + jounce_jerk_lengths(f, profile, lengths) - 1;
    jounce_add(motion, lengths[0], x, v, t->a0, t->rise);
    x += ramp(&v, t->a0, p, t->rise);
    jounce_add(motion, hold, x, v, p, 0.0);
    x += (v + 0.5 * p * hold) * hold;
    v += p * hold;
    y += ramp(&w, t->a1, q, t->rise); /* backwards in time */
    y_rear = y;
    w_rear = w;
    y -= (w - 0.5 * q * dwell) * dwell;
    w -= q * dwell;
    if (profile->cruise == 0.0) {
        jounce_add(motion, lengths[2], x, v, p, -t->fall);
    } else {
        double top = t->v_max, before = v, back = top;
        jounce_add(motion, lengths[2], x, v, p, -t->fall);
        x += ramp(&before, p, 0.0, -t->fall);
        jounce_add(motion, lengths[3], x, top, 0.0, 0.0);
        jounce_add(motion, lengths[4], y - ramp(&back, 0.0, q, -t->fall), top, 0.0, -t->fall);
    }
    jounce_add(motion, dwell, y, w, q, 0.0);
    jounce_add(motion, *last, y_rear, w_rear, q, t->rise);
}
