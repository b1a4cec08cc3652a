/* Pieces of polynomials: evaluation, and motions made of them. */
#include "task.h"

double jounce_taylor(const double *state, int order, int k, double t) {
    double value = state[order];
    int j;
    for (j = order - 1; j >= k; j--) {
        value = value * t / (double)(j + 1 - k) + state[j];
    }
    return value;
}

void jounce_add(jounce_motion *motion, double duration, double x, double v, double a, double j) {
    if (duration > 0.0 && motion->count < JOUNCE_MOST_PIECES) {
        jounce_piece *piece = &motion->pieces[motion->count++];
        piece->duration = duration;
        piece->x = x;
        piece->v = v;
        piece->a = a;
        piece->j = j;
        motion->duration += duration;
    }
}

void jounce_turn(jounce_motion *motion, int first) {
    int i;
    for (i = first; i < motion->count; i++) {
        jounce_piece *piece = &motion->pieces[i];
        piece->x = -piece->x;
        piece->v = -piece->v;
        piece->a = -piece->a;
        piece->j = -piece->j;
    }
}
