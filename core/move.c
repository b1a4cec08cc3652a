/* Moves: from rest to rest. The velocity rises to its peak and falls again, with zero acceleration
 * at the peak: a ramp up, perhaps a cruise, a ramp down; each ramp a jerk up, a hold, a jerk down.
 *
 * With bounds V, A, W on velocity, acceleration and jerk, the same in both directions, and
 * t_w = A/W (Thompson, Sections II, III), the peak velocity without a bound is
 *
 *     A (sqrt(t_w^2 + 4 R/A) - t_w)/2 where A is reached, else W (R/(2 W))^(2/3).
 *
 * Where the bounds differ it is the root of an increasing distance, halved down to the last bit.
 */
#include "task.h"

enum { MOST_DOUBLINGS = 2200 };

/* The fastest ramp from rest to a velocity, acceleration zero at both ends. */
typedef struct {
    double velocity, acceleration; /* the peaks */
    double rise, hold, fall;       /* times; without a bound on the jerk the hold alone */
} Ramp;

/* Bounds as they are met on the way: `up` and `down` of the acceleration, positive. */
typedef struct {
    double velocity, up, down, rising, falling;
} Bounds;

static Ramp ramp_to(double velocity, double acceleration, double rising, double falling) {
    Ramp r = {0.0, 0.0, 0.0, 0.0, 0.0};
    r.velocity = velocity;
    if (!is_finite(rising)) {
        r.acceleration = acceleration;
        r.hold = velocity / acceleration;
        return r;
    }
    r.acceleration = square_root(2.0 * velocity / (1.0 / rising + 1.0 / falling));
    if (r.acceleration <= acceleration) {
        r.rise = r.acceleration / rising;
        r.fall = r.acceleration / falling;
        return r;
    }
    r.acceleration = acceleration;
    r.rise = acceleration / rising;
    r.fall = acceleration / falling;
    r.hold = larger(velocity / acceleration - 0.5 * (r.rise + r.fall), 0.0);
    return r;
}

static double rise_distance(const Ramp *r) { return r->acceleration * r->rise * r->rise / 6.0; }

static double rise_velocity(const Ramp *r) { return 0.5 * r->acceleration * r->rise; }

static double held_velocity(const Ramp *r) {
    return r->velocity - 0.5 * r->acceleration * r->fall;
}

static double held_distance(const Ramp *r) {
    return rise_distance(r) + 0.5 * (rise_velocity(r) + held_velocity(r)) * r->hold;
}

static double ramp_distance(const Ramp *r) {
    return held_distance(r) + (held_velocity(r) + r->acceleration * r->fall / 3.0) * r->fall;
}

static int is_even(const Bounds *b) { return b->up == b->down && b->rising == b->falling; }

static Ramp way_up(double velocity, const Bounds *b) {
    return ramp_to(velocity, b->up, b->rising, b->falling);
}

/* Run backwards in time, the way down from a velocity. */
static Ramp way_down(double velocity, const Bounds *b) {
    return ramp_to(velocity, b->down, b->rising, b->falling);
}

static int fits(double velocity, double distance, const Bounds *b) {
    Ramp up = way_up(velocity, b), down = way_down(velocity, b);
    return ramp_distance(&up) + ramp_distance(&down) <= distance;
}

/* The velocity that the move would reach without a bound on velocity. */
static double free_velocity(double distance, const Bounds *b) {
    double low, high, gentlest = smaller(b->rising, b->falling);
    int i;
    if (!is_finite(gentlest)) {
        return square_root(2.0 * distance / (1.0 / b->up + 1.0 / b->down));
    }
    low = cube_root(0.5 * distance / gentlest);
    if (is_even(b)) {
        double ramp = b->up / gentlest;
        return gentlest * low <= b->up
                   ? gentlest * low * low
                   : b->up * 0.5 * (square_root(ramp * ramp + 4.0 * distance / b->up) - ramp);
    }
    low = high = gentlest * low * low;
    for (i = 0; i < MOST_DOUBLINGS && !fits(low, distance, b); i++) {
        low *= 0.5;
    }
    for (i = 0; i < MOST_DOUBLINGS && fits(high, distance, b); i++) {
        high *= 2.0;
    }
    for (i = 0; i < MOST_DOUBLINGS; i++) {
        double middle = 0.5 * (low + high);
        if (!(low < middle && middle < high)) {
            break;
        }
        if (fits(middle, distance, b)) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

typedef struct {
    Ramp up, down;
    double cruise;
} Shape;

static Shape shape_of(double distance, const Bounds *b) {
    double velocity = b->velocity;
    Shape s;
    s.cruise = 0.0;
    if (is_finite(velocity)) {
        s.up = way_up(velocity, b);
        s.down = b->down == b->up ? s.up : way_down(velocity, b);
        s.cruise = (distance - ramp_distance(&s.up) - ramp_distance(&s.down)) / velocity;
        if (s.cruise >= 0.0) {
            return s;
        }
        s.cruise = 0.0;
    }
    velocity = smaller(velocity, free_velocity(distance, b));
    s.up = way_up(velocity, b);
    s.down = b->down == b->up ? s.up : way_down(velocity, b);
    return s;
}

/* The jerks are those that lead to the peaks, which rounding may have put beside the bounds. */
static void add_pieces(const Shape *s, const Bounds *b, double distance, jounce_motion *m) {
    const Ramp *up = &s->up, *down = &s->down;
    double v = up->velocity, rising, falling;
    if (!is_finite(b->rising)) {
        jounce_add(m, up->hold, 0.0, 0.0, up->acceleration, 0.0);
        jounce_add(m, s->cruise, ramp_distance(up), v, 0.0, 0.0);
        jounce_add(m, down->hold, distance - ramp_distance(down), v, -down->acceleration, 0.0);
        return;
    }
    rising = up->acceleration / up->rise;
    falling = -up->acceleration / up->fall;
    jounce_add(m, up->rise, 0.0, 0.0, 0.0, rising);
    jounce_add(m, up->hold, rise_distance(up), rise_velocity(up), up->acceleration, 0.0);
    if (s->cruise == 0.0 && b->up == b->down) {
        jounce_add(m, 2.0 * up->fall, held_distance(up), held_velocity(up), up->acceleration,
                   falling);
    } else { /* unequal ramps meet at zero acceleration, or the larger's rounding spoils the other */
        jounce_add(m, up->fall, held_distance(up), held_velocity(up), up->acceleration, falling);
        jounce_add(m, s->cruise, ramp_distance(up), v, 0.0, 0.0);
        jounce_add(m, down->fall, distance - ramp_distance(down), v, 0.0, falling);
    }
    jounce_add(m, down->hold, distance - held_distance(down), held_velocity(down),
               -down->acceleration, 0.0);
    jounce_add(m, down->rise, distance - rise_distance(down), rise_velocity(down),
               -down->acceleration, rising);
}

/* The bounds of a move in positive direction, or of one in negative direction seen from behind. */
static Bounds forward_bounds(const jounce_task *t) {
    int ahead = t->distance >= 0.0;
    Bounds b;
    b.velocity = ahead ? t->v_max : -t->v_min;
    b.up = ahead ? t->a_max : -t->a_min;
    b.down = ahead ? -t->a_min : t->a_max;
    b.rising = ahead ? t->rise : t->fall;
    b.falling = ahead ? t->fall : t->rise;
    return b;
}

/* Without bounds of acceleration and jerk: all of the distance at one velocity. */
static jounce_status glide(double distance, const jounce_limits *l, jounce_motion *m) {
    double v = distance > 0.0 ? l->v_high : l->v_low;
    jounce_add(m, distance / v, 0.0, v, 0.0, 0.0);
    return m->duration > 0.0 && is_finite(m->duration) ? JOUNCE_OK : JOUNCE_RANGE;
}

static inline int moderate(double x) { return x == INFINITE || (x > 1e-60 && x < 1e60); }

/* Which bounds a move meets where they are the same both ways. */
enum { MEETS_BOTH, MEETS_ACCELERATION, MEETS_VELOCITY, MEETS_NEITHER, OTHER };

/* A move that is the same seen from its end: its bounds, and the times in which the jerk leads to
 * the acceleration and the acceleration to the velocity. */
typedef struct {
    double distance, velocity, acceleration, jerk;
    double push, hold;
} Even;

static inline Even even_of(double distance, double velocity, double acceleration, double jerk) {
    Even m;
    m.distance = distance;
    m.velocity = velocity;
    m.acceleration = acceleration;
    m.jerk = jerk;
    m.push = acceleration / jerk; /* zero without a bound of the jerk */
    m.hold = velocity / acceleration;
    return m;
}

/* Cubes must not leave the range. All is compared before anything is chosen: there is nothing for
 * the processor to guess. */
static inline int form_of(const Even *m) {
    int cruises = m->distance >= m->velocity * (m->hold + m->push);
    int holds = m->distance >= 2.0 * m->acceleration * m->push * m->push;
    int peaks =
        m->distance * m->distance * m->jerk > 4.0 * m->velocity * m->velocity * m->velocity;
    int held = cruises ? MEETS_BOTH : holds ? MEETS_ACCELERATION : MEETS_NEITHER;
    int free = peaks ? MEETS_VELOCITY : MEETS_NEITHER;
    return m->hold >= m->push ? held : free; /* is the acceleration reached before the velocity? */
}

static inline double even_duration(int form, const Even *m) {
    switch (form) {
    case MEETS_BOTH:
        return m->distance / m->velocity + m->hold + m->push;
    case MEETS_ACCELERATION:
        return m->push + square_root(m->push * m->push + 4.0 * m->distance / m->acceleration);
    case MEETS_VELOCITY:
        return m->distance / m->velocity + 2.0 * square_root(m->velocity / m->jerk);
    default:
        return 4.0 * cube_root(0.5 * m->distance / m->jerk);
    }
}

static inline int has_formula(const Even *m) {
    double least = smaller(smaller(m->distance, m->velocity), smaller(m->acceleration, m->jerk));
    double most = larger(larger(m->distance, m->velocity), larger(m->acceleration, m->jerk));
    if (least > 1e-60 && most < 1e60) { /* as mostly, which is told with fewer looks */
        return 1;
    }
    return (is_finite(m->acceleration) || is_finite(m->jerk)) && moderate(m->distance) &&
           moderate(m->velocity) && moderate(m->acceleration) && moderate(m->jerk);
}

/* The duration of a move that is the same seen from its end, by a formula; 0 where there is none. */
static double by_formula(double distance, const jounce_limits *l) {
    Even m = even_of(magnitude(distance), distance >= 0.0 ? l->v_high : -l->v_low, l->a_high,
                     l->j_high);
    if (l->a_high != -l->a_low || l->j_high != -l->j_low || !has_formula(&m)) {
        return 0.0;
    }
    return even_duration(form_of(&m), &m);
}

jounce_status jounce_move(double distance, const jounce_limits *limits, jounce_motion *motion) {
    jounce_state start = {0.0, 0.0, 0.0}, end = {distance, 0.0, 0.0};
    double duration = by_formula(distance, limits);
    jounce_status status;
    jounce_problem p;
    Bounds b;
    Shape s;
    jounce_clear(motion);
    motion->end = end;
    if (distance == 0.0) {
        return JOUNCE_OK;
    }
    if (!is_finite(limits->a_high) && !is_finite(limits->j_high)) {
        return glide(distance, limits, motion);
    }
    jounce_pose(&start, &end, limits, magnitude(distance), 0.0, &p);
    b = forward_bounds(&p.whole);
    s = shape_of(magnitude(p.whole.distance), &b);
    add_pieces(&s, &b, magnitude(p.whole.distance), motion);
    if (distance < 0.0) {
        jounce_turn(motion, 0);
    }
    status = jounce_finish(&p, &end, limits, motion);
    if (duration > 0.0) {
        motion->duration = duration;
    }
    return status;
}

double jounce_move_duration(double distance, const jounce_limits *limits) {
    double duration = by_formula(distance, limits);
    jounce_motion motion;
    if (duration > 0.0) {
        return duration;
    }
    return jounce_move(distance, limits, &motion) == JOUNCE_OK ? motion.duration
                                                               : INFINITE - INFINITE;
}

/* --- many moves -------------------------------------------------------------------------------- */

enum { BLOCK = 256 };

static inline double at(const jounce_column *column, size_t i) {
    return column->values[i * column->step];
}

static jounce_limits limits_at(const jounce_columns *c, size_t i) {
    double low[3] = {-INFINITE, -INFINITE, -INFINITE}, high[3] = {INFINITE, INFINITE, INFINITE};
    jounce_limits limits;
    int k;
    for (k = 0; k < c->order; k++) {
        high[k] = at(&c->upper[k], i);
        low[k] = c->even ? -high[k] : at(&c->lower[k], i);
    }
    limits.v_low = low[0];
    limits.v_high = high[0];
    limits.a_low = low[1];
    limits.a_high = high[1];
    limits.j_low = low[2];
    limits.j_high = high[2];
    return limits;
}

/* First which form each has, then form by form: what a processor need not guess, it does ahead. */
static void durations_of_some(const jounce_column *distances, const jounce_columns *c,
                              size_t first, size_t count, double *durations) {
    const double unbounded = INFINITE;
    const jounce_column none = {&unbounded, 0}, *v = &c->upper[0];
    const jounce_column *a = c->order > 1 ? &c->upper[1] : &none;
    const jounce_column *j = c->order > 2 ? &c->upper[2] : &none;
    unsigned short lanes[OTHER + 1][BLOCK];
    size_t counts[OTHER + 1] = {0}, i, k;
    Even moves[BLOCK];
    int form;
    for (k = 0; k < count; k++) {
        i = first + k;
        moves[k] = even_of(magnitude(at(distances, i)), at(v, i), at(a, i), at(j, i));
        form = c->even && has_formula(&moves[k]) ? form_of(&moves[k]) : OTHER;
        lanes[form][counts[form]++] = (unsigned short)k;
    }
    for (form = 0; form < OTHER; form++) {
        for (k = 0; k < counts[form]; k++) {
            durations[first + lanes[form][k]] = even_duration(form, &moves[lanes[form][k]]);
        }
    }
    for (k = 0; k < counts[OTHER]; k++) {
        jounce_limits limits = limits_at(c, i = first + lanes[OTHER][k]);
        durations[i] = jounce_move_duration(at(distances, i), &limits);
    }
}

void jounce_move_durations(const jounce_column *distances, const jounce_columns *bounds,
                           size_t count, double *durations) {
    size_t first;
    for (first = 0; first < count; first += BLOCK) {
        size_t left = count - first;
        durations_of_some(distances, bounds, first, left < BLOCK ? left : BLOCK, durations);
    }
}
