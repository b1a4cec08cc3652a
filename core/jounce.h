/* jounce.h: motion with bounded derivatives, in C99.
 *
 * The caller owns all memory; nothing here allocates, prints, keeps a global or calls libm.
 * Functions return a status; what they compute comes out last. Units are the caller's, any
 * consistent ones of time and distance: problems are scaled by powers of two before they are
 * solved, so that results do not depend on the units.
 *
 * Compile with -ffp-contract=off: the same bits then come out of every platform.
 */
#ifndef JOUNCE_H
#define JOUNCE_H

#include <stddef.h>
#include <stdint.h>

typedef enum {
    JOUNCE_OK = 0,
    JOUNCE_UNREACHABLE, /* no motion within the bounds leads to the end */
    JOUNCE_NO_DURATION, /* no motion within the bounds takes this long */
    JOUNCE_RANGE,       /* times or states leave the range of a double */
    JOUNCE_FULL,        /* no room for what comes out */
    JOUNCE_CHATTER      /* modes change for ever at one instant */
} jounce_status;

/* Bounds low < 0 < high on velocity, acceleration and jerk. Infinity is no bound; without bounds
 * of the jerk the acceleration may jump ("order 2"), and must be bounded on both sides. A jerk
 * that is bounded is so on both sides. */
typedef struct {
    double v_low, v_high;
    double a_low, a_high;
    double j_low, j_high;
} jounce_limits;

typedef struct {
    double x, v, a;
} jounce_state;

/* From (x, v, a) with constant jerk j, or with constant acceleration where j is 0. */
typedef struct {
    double duration;
    double x, v, a, j;
} jounce_piece;

enum { JOUNCE_MOST_PIECES = 24 };

/* A motion from time 0 on. Pieces have positive durations and follow one another. */
typedef struct {
    int count;
    double duration;     /* the sum of the durations, to rounding */
    double inside_after; /* the time after which every bound holds for good */
    jounce_state end;
    jounce_piece pieces[JOUNCE_MOST_PIECES];
} jounce_motion;

/* --- transfers: from any state of motion to any other (transfer.c) -------------------------- */

/* The fastest motion from start to end.
 *
 * A start beyond its bounds, or bound to leave them, is brought inside first (inside.c says how).
 * The end must be inside its bounds. `motion` is complete only where JOUNCE_OK is returned. */
jounce_status jounce_transfer(const jounce_state *start, const jounce_state *end,
                              const jounce_limits *limits, jounce_motion *motion);

/* Its duration, inside_after and number of pieces alone, to the bit, which cost less: the pieces and
 * the end of `motion` are left open. */
jounce_status jounce_transfer_times(const jounce_state *start, const jounce_state *end,
                                    const jounce_limits *limits, jounce_motion *motion);

/* The fastest change to velocity end->v and acceleration end->a, wherever that ends. */
jounce_status jounce_velocity_transfer(const jounce_state *start, const jounce_state *end,
                                       const jounce_limits *limits, jounce_motion *motion);

/* The durations that a transfer can take, as increasing intervals; the last `high` may be
 * infinite. */
typedef struct {
    double low, high;
} jounce_interval;

enum { JOUNCE_MOST_INTERVALS = 16 };

typedef struct {
    int count;
    jounce_interval intervals[JOUNCE_MOST_INTERVALS];
} jounce_durations;

jounce_status jounce_possible_durations(const jounce_state *start, const jounce_state *end,
                                        const jounce_limits *limits,
                                        jounce_durations *durations);

/* A transfer of a given duration: to one velocity, along at it, and to the end's, if possible. */
jounce_status jounce_transfer_lasting(const jounce_state *start, const jounce_state *end,
                                      const jounce_limits *limits, double duration,
                                      jounce_motion *motion);

/* --- several axes (synchronize.c) --------------------------------------------------------------- */

/* The shortest duration that lies in an interval of every axis; infinite where there is none. */
double jounce_common_duration(const jounce_durations *possible, int axes);

/* All axes take the shortest duration that every one of them can take. `possible` (one an axis)
 * receives the durations, `motions` (one an axis) the plans, `failed` the axis that an error is
 * about, -1 where it is about all of them together. */
jounce_status jounce_synchronize(const jounce_state *starts, const jounce_state *ends,
                                 const jounce_limits *limits, int axes,
                                 jounce_durations *possible, jounce_motion *motions,
                                 int *failed);

/* --- moves: from rest to rest, starting at position 0 (move.c) --------------------------------- */

/* Here the acceleration may be unbounded as well, where velocity is bounded: it then jumps. */
jounce_status jounce_move(double distance, const jounce_limits *limits, jounce_motion *motion);

/* Its duration alone, which costs less; NaN where there is no such move. */
double jounce_move_duration(double distance, const jounce_limits *limits);

/* Numbers of many problems; that of all where the step is zero. */
typedef struct {
    const double *values;
    size_t step;
} jounce_column;

/* Their bounds on 1 to 3 derivatives, velocity first; even ones have no columns of lower bounds. */
typedef struct {
    int order, even;
    jounce_column lower[3], upper[3];
} jounce_columns;

/* The durations of many moves, to the bit those of one. */
void jounce_move_durations(const jounce_column *distances, const jounce_columns *bounds,
                           size_t count, double *durations);

/* --- followers (follower.c) ------------------------------------------------------------------ */

typedef struct {
    jounce_limits limits;
    double dt;     /* length of a sample */
    double period; /* of an axis that wraps around; infinite for one that does not */
} jounce_follower;

/* The motion during the sample that begins at `state`: its pieces, at most `dt` long, and its
 * end. */
jounce_status jounce_follow(const jounce_follower *follower, const jounce_state *state,
                            double command, double command_velocity, jounce_motion *motion);

/* --- equal first-order lags in series: a jerk filter (lags.c) ------------------------------------ */

enum { JOUNCE_MOST_LAGS = 50 };

/* Advance lags by tau behind a motion that has the derivatives 0 ... order given; order < 40. */
void jounce_advance_lags(double *lags, int count, const double *motion, int order, double tau,
                         double omega);

/* Advance lags behind the first `duration` of a motion. */
void jounce_lags_behind(double *lags, int count, const jounce_motion *motion, double duration,
                        double omega);

/* Position and derivatives 1 ... highest behind the lags; `motion` are those before them. */
void jounce_lags_output(const double *lags, int count, const double *motion, int highest,
                        double omega, double *out);

/* --- linear systems under held inputs (linear.c) ------------------------------------------------ */

/* x' = A x + B u and y = C x + D u, row by row. a and b are those of balanced states: A is
 * scale[i] a[i][j] / scale[j] and B scale[i] b[i][j], with scales that are powers of two. */
typedef struct {
    int states, inputs, outputs;
    const double *a, *b, *c, *d;
    const double *scale;
} jounce_linear;

void jounce_linear_outputs(const jounce_linear *system, const double *x, const double *u,
                           double *y);

void jounce_linear_rates(const jounce_linear *system, const double *x, const double *u,
                         double *rates);

/* How many numbers of work space a system takes. */
#define JOUNCE_LINEAR_WORK(n, inputs) (1 + 4 * (n) * (n) + (n) * (inputs) + (n))

/* Advance the states by h. `work` is zeroed before the first step; it keeps the matrix exponential,
 * which is taken again only where h differs by more than `slack`. */
void jounce_linear_step(const jounce_linear *system, const double *u, double h, double slack,
                        double *work, double *x);

/* Rows of by_state x + by_input u: a discrete system's next states, or its outputs. */
void jounce_weigh(const double *by_state, const double *by_input, int rows,
                  const jounce_linear *sizes, const double *x, const double *u, double *result);

/* --- controller (controller.c) ------------------------------------------------------------------- */

/* u = kp e + ki I + kr e' + inertia r'', with I the running sum of dt e. */
typedef struct {
    double kp, ki, kr, inertia, dt;
} jounce_pid;

/* `integral` is that of the sample before. */
double jounce_pid_output(const jounce_pid *pid, double integral, double e, double e_rate,
                         double r_acceleration);

/* The integral after this sample. */
double jounce_pid_integral(const jounce_pid *pid, double integral, double e);

/* The whole of a digital controller, run once a sample (controller.c):
 *
 *   e = sum of position[k] r^(k) - y;   PID: w = kp e + ki I + kr D, I += dt e,
 *   D = (rate_filter D + e - e_before)/(rate_filter + dt);
 *   cascade: w = kp x + ki I, I += dt x, x = position_gain e + velocity_feedforward r' - v,
 *   v = (rate_filter v + y - y_before)/(rate_filter + dt);
 *
 * then the sections of its filters, sum of torque[k] r^(k) + friction sign(r'), the limit, and what
 * keeps the integral from winding up. Positions are read in steps of the encoder, if it has any. */
enum { JOUNCE_PID, JOUNCE_CASCADE };

enum { JOUNCE_WINDS_UP, JOUNCE_CONDITIONAL, JOUNCE_BACK_CALCULATION, JOUNCE_CLAMP };

typedef struct {
    int law, anti_windup, sections, order;
    double dt, kp, ki, kr, rate_filter;
    double position_gain, velocity_feedforward;
    double friction, limit, tracking_time, integral_limit, encoder_step;
    const double *section;           /* b0, b1, b2, a1, a2 of each */
    const double *position, *torque; /* gains of derivatives 0 ... order of the command, order >= 1 */
} jounce_controller;

/* Numbers in its state, all 0 before the first sample; the integral is number 1. */
#define JOUNCE_CONTROLLER_STATE(sections) (4 + 2 * (sections))

/* One sample: `position` and `motor` are what the error and the velocity are taken from, `command`
 * the command with its derivatives, `ahead` the same a lead later, for the torque. `out` receives
 * e, w and the torque u within the limit. */
void jounce_controller_sample(const jounce_controller *controller, double *state, double position,
                              double motor, const double *command, const double *ahead,
                              double *out);

/* --- piecewise linear systems, exact from event to event (automaton.c) ---------------------------- */

/* z' = rates z in each mode, for as long as every guard's row z is positive; when it has fallen to 0
 * the system is in another mode, and z += onto (along z). */
typedef struct {
    int states, moving; /* n; only the first `moving` of them change, the others are held */
    int modes, guards;
    const double *rates;        /* modes x moving x n */
    const double *rows;         /* modes x guards x n */
    const double *next;         /* modes x guards: the mode beyond a guard, -1 for no guard */
    const double *onto, *along; /* modes x guards x n */
} jounce_automaton;

enum { JOUNCE_TERMS = 25 }; /* of a Taylor series; ||rates|| times a step is at most 2 */

/* A run is prepared for steps of two lengths, the longer first; shorter ones are free. */
#define JOUNCE_AUTOMATON_WORK(n, moving, modes, guards) \
    ((modes) * (2 * (moving) * (n) + (guards) * (n) * (14 + JOUNCE_TERMS)) + \
     (JOUNCE_TERMS + 2) * (n) + (moving) * (n) * 2 + 2 * JOUNCE_TERMS)

/* A run of it: `segments` receives a row of time, mode and z at the start of every step, and the
 * last at the end; it may be NULL. */
typedef struct {
    const jounce_automaton *automaton;
    double steps[2];
    double *work;
    double *z;
    int mode, at_once, holding; /* changes of mode since time went on, and one that holds, or -1 */
    double *segments;
    size_t count, room;
} jounce_run;

void jounce_prepare(jounce_run *run);

/* Put down time, mode and z; JOUNCE_FULL without room for them. */
jounce_status jounce_record(jounce_run *run, double t);

/* Go on from time t for `span`. JOUNCE_FULL without room for segments, JOUNCE_CHATTER where modes
 * change for ever at one instant. */
jounce_status jounce_advance(jounce_run *run, double t, double span);

/* --- a servo loop over time (loop.c) --------------------------------------------------------------- */

/* A controller, or none, over an automaton; samples k = 0, 1, ... at k dt act `delay` later. At given
 * times states from `place` on are set to new values, but where these are not numbers. */
typedef struct {
    const jounce_controller *controller;
    double duration, delay;
    int samples, held; /* how many samples; the place of the torque in z */
    const double *position, *motor; /* rows over z of what is measured */
    const double *commands, *ahead; /* samples x (order + 1) */
    const double *noise;            /* added to what is measured, samples; or NULL */
    int settings, place, width;
    const double *times, *values; /* settings, settings x width */
} jounce_loop;

/* Run it from time 0: `state` is the controller's, `out` receives e, w and u of every sample. */
jounce_status jounce_run_loop(const jounce_loop *loop, jounce_run *run, double *state,
                              double *out);

/* --- balancing (balance.c) ------------------------------------------------------------------------ */

/* a (n x n) becomes 1/D a D, D the diagonal of `scale`: powers of two with which rows and columns
 * have like norms. */
void jounce_balance(double *a, double *scale, int n);

/* --- evaluation of pieces of any order (pieces.c, evaluation.c, many_times.c) ------------------ */

/* Derivative k of x(t) = sum over j of state[j] t^j / j!, j = 0 ... order. */
double jounce_taylor(const double *state, int order, int k, double t);

enum { JOUNCE_MOST_ORDER = 40 };

/* A function of time in pieces. */
typedef struct {
    int order;               /* n, the highest derivative, at most JOUNCE_MOST_ORDER */
    size_t count;            /* m */
    const double *breaks;    /* m + 1, increasing */
    const double *states;    /* m + 2 rows of position and derivatives 1 ... n: at breaks[0] for */
                             /* the time before, at the start of each piece, after the last */
    const double *durations; /* m; no piece is run past its own */
} jounce_pieces;

/* How many breaks are at or before a time: the row of the state that it goes on from. */
size_t jounce_breaks_up_to(const jounce_pieces *pieces, double time);

/* Derivatives 0 ... last at one time. A time before a break by at most `early` counts as behind
 * it, for hosts that add up their time; where it is not finite, neither is what comes out. */
void jounce_evaluate_at(const jounce_pieces *pieces, double time, double early, int last,
                        double *out);

/* Derivatives first ... last at times, that of k in out[(k - first) * stride]; increasing times
 * are fastest. JOUNCE_RANGE where a time is not finite. */
jounce_status jounce_evaluate(const jounce_pieces *pieces, const double *times, size_t count,
                              int first, int last, double *out, size_t stride);

#endif
