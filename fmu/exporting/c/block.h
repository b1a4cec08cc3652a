/* What a block is to the wrappers: its variables, its state, and the functions of its core. */

#include <stddef.h>
#include <stdint.h>

/* No fused multiply-add: the same bits everywhere. GCC does not know the standard's pragma. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off")
#elif defined(_MSC_VER)
#pragma fp_contract(off)
#else
#pragma STDC FP_CONTRACT OFF
#endif

#define START 1       /* may be set until the block is initialised */
#define TUNABLE 2     /* may be set at any time, as may an input */
#define INPUT 4
#define STATE 8       /* a continuous state */
#define OUTPUT 16
#define DERIVATIVE 32 /* of a continuous state */

typedef struct {
    int flags;
    double start, least, most;
    const char *name;
} Variable;

#include "model.h"

#define N_SOME(n) ((n) > 0 ? (n) : 1)

enum { INSTANTIATED, INITIALIZING, STEPPING, TERMINATED };

/* All that a snapshot keeps; eight bytes each, so that there is no padding. */
typedef struct {
    double value[N_SOME(N_VARIABLES)]; /* by value reference - 1 */
    double memory[N_SOME(N_MEMORY)];   /* what a core keeps beside its variables */
    double start, stop, time;          /* stop is below start where there is none */
    int64_t ticks;                     /* samples run so far */
    int64_t phase;
} State;

/* Work space, and what depends on the step size alone; may be zeroed at any time. */
typedef struct {
    double work[N_SOME(N_WORK)];
} Cache;

/* A core is a file that defines
 *   core_initialize   derives states from start values
 *   core_outputs      computes outputs from states and inputs; `running` after initialisation
 *   core_step         goes on from t to t + h; returns what went wrong, or NULL
 *   core_partial      derivative of a variable by an input or state (HAS_PARTIALS)
 */
