/* What the parts of the planner share: a problem in its own units, and pieces as they are found. */
#ifndef JOUNCE_TASK_H
#define JOUNCE_TASK_H

#include "jounce.h"
#include "numeric.h"

/* From velocity v0 and acceleration a0 to v1 and a1 over a signed distance, within bounds.
 *
 * `rise` and `fall` are the largest rates of rising and falling acceleration, both positive; with
 * infinite ones the acceleration may jump, a0 = a1 = 0, and both of its bounds are finite. */
typedef struct {
    double distance;
    double v0, a0, v1, a1;
    double v_min, v_max, a_min, a_max;
    double fall, rise;
    double resolution; /* what rounding of the two positions leaves of the distance */
} jounce_task;

/* The same problem seen in the opposite direction. */
jounce_task jounce_mirrored(const jounce_task *task);

/* Powers of two: a unit of time 2^time and one of distance 2^length. */
typedef struct {
    int time, length;
} jounce_units;

/* Bring a task into its own units, in which its times, and a duration asked for (or 0), are of
 * order one (scaling.c). */
jounce_units jounce_to_own_units(jounce_task *task, double duration);

/* --- pieces (pieces.c) ------------------------------------------------------------------------ */

/* Append a piece, where it takes any time. */
void jounce_add(jounce_motion *motion, double duration, double x, double v, double a, double j);

/* Turn the pieces from `first` on into those of the opposite direction. */
void jounce_turn(jounce_motion *motion, int first);

/* Distance and change of velocity while the acceleration goes from a to end within a time t. */
static inline double ramp_in(double *v, double a, double end, double t) {
    double distance = (*v + (2.0 * a + end) * (1.0 / 6.0) * t) * t;
    *v += 0.5 * (a + end) * t;
    return distance;
}

/* The same with jerk j. */
static inline double ramp(double *v, double a, double end, double j) {
    return ramp_in(v, a, end, (end - a) / j);
}

/* --- changes of velocity (velocity_change.c) -------------------------------------------------- */

/* Acceleration a0 -> peak, hold, peak -> a1; without bounds of the jerk only the hold. */
typedef struct {
    double duration, distance;
    double peak, first, hold, last; /* the times to the peak, at it and from it */
    double jerk, back;              /* of the way to the peak, and from it */
} jounce_change;

/* The fastest change from (v0, a0) to (v1, a1); the task's distance plays no part. */
jounce_change jounce_change_velocity(const jounce_task *task);

/* Whether the velocity passes its bound where the acceleration crosses zero on the way back. */
int jounce_change_leaves_bounds(const jounce_task *task, const jounce_change *change);

void jounce_change_pieces(const jounce_task *task, const jounce_change *change, double x,
                          jounce_motion *motion);

/* A transfer whose positions are known only to what they are worth in 2^-52 of `size` (transfer.c). */
jounce_status jounce_approach(const jounce_state *start, const jounce_state *end,
                              const jounce_limits *limits, double size, jounce_motion *motion);

/* --- starts outside (inside.c) ---------------------------------------------------------------- */

static inline int jounce_starts_within(const jounce_task *t) {
    return t->v_min <= t->v0 && t->v0 <= t->v_max && t->a_min <= t->a0 && t->a0 <= t->a_max;
}

/* Bring the task's start to where its bounds can be kept for good; add the pieces of the way from
 * position x, and return the position reached. */
double jounce_bring_inside(jounce_task *task, double x, jounce_motion *motion);

/* Bring the start's acceleration alone inside its bounds. */
double jounce_bring_acceleration_inside(jounce_task *task, double x, jounce_motion *motion);

/* The time in a motion after which v and a keep their bounds for good. */
double jounce_time_inside(const jounce_task *task, const jounce_motion *motion);

/* Cut off an excess over the bounds that is mere rounding. */
double jounce_inside(double value, double low, double high);

/* --- the profiles that go furthest in their time ----------------------------------------------- */

/* With bounded jerk: acceleration rises to p, holds, falls to q (cruising where it is zero),
 * dwells, rises. With bounded acceleration: velocity rises by p, cruises, falls. */
typedef struct {
    double duration, p, hold, cruise, q, dwell;
    double worth; /* time that its error of the distance takes, where it has one */
    double first, fall, last; /* with bounded jerk: p - a0, p - q, a1 - q to their own last digits */
} jounce_profile;

/* With more profiles a frame takes more than a page, which Windows wants looked after. */
enum { JOUNCE_MOST_PROFILES = 24, JOUNCE_MOST_LENGTHS = 7 };

typedef struct {
    int count;
    jounce_profile profiles[JOUNCE_MOST_PROFILES];
} jounce_profiles;

/* An acceleration from or to which a profile cruises: its size, and what it is beyond that at the end
 * of the motion. */
typedef struct {
    double size, beyond;
} jounce_peak;

/* A family seen from one end: as it is, or backwards in time, where -q is what p was. */
typedef struct {
    double a0, a1, gain, v1; /* gain = v1 - v0 */
    double ratio;            /* p^2 - q^2 where nothing is held */
    double top, bottom;      /* bounds of p and q */
    jounce_peak p_cruise, q_cruise;
    int may_rise, may_dip; /* p above zero, and q below it */
    int uneven;            /* the jerks differ so much that digits count */
} jounce_view;

/* What depends on the task alone. */
typedef struct {
    jounce_task task;
    double rounding;          /* an error of the distance that is mere rounding of itself */
    double speed;             /* the larger one of both ends */
    double rise_time, fall_time; /* of a unit of acceleration; the rest is the jerk's */
    double half_rise, half_fall, kappa, per_kappa; /* kappa = 1/(2 rise) + 1/(2 fall) */
    double ratio;
    jounce_view ahead, back;
} jounce_family;

/* Work out what depends on the family's task. */
void jounce_jerk_family(jounce_family *family);
/* An error of the distance that is rounding of the states of motion. */
double jounce_jerk_blur(const jounce_family *family);
void jounce_jerk_solutions(const jounce_family *family, jounce_profiles *found);
/* The shortest profile that covers the task's distance; 0 where there is none. The family begins
 * with a distance, infinite where it is not known. */
int jounce_jerk_shortest(const jounce_family *family, double begins, jounce_profile *best);

int jounce_jerk_lasting(const jounce_family *family, double duration, jounce_profile *profile);
int jounce_jerk_edges(const jounce_family *family, double *durations);
double jounce_jerk_distance(const jounce_family *family, const jounce_profile *profile);
int jounce_jerk_lengths(const jounce_family *family, const jounce_profile *profile,
                        double *lengths);
void jounce_jerk_pieces(const jounce_family *family, const jounce_profile *profile, double start,
                        double end, jounce_motion *motion);

void jounce_speed_family(jounce_family *family);
double jounce_speed_blur(const jounce_family *family);
void jounce_speed_solutions(const jounce_family *family, jounce_profiles *found);
int jounce_speed_lasting(const jounce_family *family, double duration, jounce_profile *profile);
int jounce_speed_edges(const jounce_family *family, double *durations);
double jounce_speed_distance(const jounce_family *family, const jounce_profile *profile);
int jounce_speed_lengths(const jounce_family *family, const jounce_profile *profile,
                         double *lengths);
void jounce_speed_pieces(const jounce_family *family, const jounce_profile *profile, double start,
                         double end, jounce_motion *motion);

/* The same, whether the jerk is bounded or not (families.c). */
void jounce_make_family(jounce_family *family);
double jounce_blur(const jounce_family *family);
void jounce_solutions(const jounce_family *family, jounce_profiles *found);
int jounce_shortest(const jounce_family *family, double begins, jounce_profile *best);
int jounce_lasting(const jounce_family *family, double duration, jounce_profile *profile);
int jounce_edges(const jounce_family *family, double *durations);
double jounce_distance_of(const jounce_family *family, const jounce_profile *profile);
/* The durations of its pieces, zeros among them; returns how many there are. */
int jounce_lengths_of(const jounce_family *family, const jounce_profile *profile, double *lengths);
void jounce_pieces_of(const jounce_family *family, const jounce_profile *profile, double start,
                      double end, jounce_motion *motion);

/* Add the fastest plan of a task that starts inside; 0 where there is none (transfer.c). */
int jounce_fastest(const jounce_task *task, double start, double end, jounce_motion *motion);

/* --- problems (transfer.c) ----------------------------------------------------------------------- */

/* A transfer in its own units, its start brought inside. */
typedef struct {
    jounce_status status;    /* OK where the end keeps its bounds, at a distance that doubles hold */
    jounce_task whole, task; /* as asked, and what is left after the way inside */
    jounce_units units;
    double start, position, goal; /* of the whole, of the task, and the end, */
    double offset;                /* from here, which is not zero where all three are one double */
    jounce_motion way;            /* inside */
} jounce_problem;

/* Scale a problem to its own units; positions are known to 2^-52 of `size`, and `duration` is asked
 * for, or 0. */
void jounce_pose(const jounce_state *start, const jounce_state *end, const jounce_limits *limits,
                 double size, double duration, jounce_problem *problem);
double jounce_size_of_positions(const jounce_state *start, const jounce_state *end);

/* Bring its start inside. */
void jounce_start_inside(jounce_problem *problem);

/* Scale a plan back to the caller's units; it ends at `end`. */
jounce_status jounce_finish(const jounce_problem *problem, const jounce_state *end,
                            const jounce_limits *limits, jounce_motion *motion);

void jounce_clear(jounce_motion *motion);

/* Start a motion with the way inside. */
void jounce_begin_with(const jounce_motion *way, jounce_motion *motion);

#endif
