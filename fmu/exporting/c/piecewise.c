/* A motion planned beforehand, as the core evaluates it. */

#include "evaluation.c"

static const jounce_pieces planned = {ORDER, N_PIECES, breaks, states[0], durations};
