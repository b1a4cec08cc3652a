/* Pieces of polynomials at many times, taken in runs within one piece.
 *
 * So increasing times need no search, and a run is evaluated a tile at a time.
 */
#include "evaluation.h"

enum { TILE = 64, SHORT = 8 };

/* Compiled twice, for the processor's wider registers too: the bits are the same. */
#if defined(__GNUC__) && defined(__x86_64__) && defined(__GLIBC__)
#define WIDE __attribute__((target_clones("avx2", "default")))
#else
#define WIDE
#endif

static int holds(const Span *s, double t) { return s->low <= t && t < s->high; }

/* The piece of a finite time, the next one first. */
static Span find(const jounce_pieces *p, const Span *before, double t) {
    if (before->index <= p->count) {
        Span next = span(p, before->index + 1);
        if (holds(&next, t)) {
            return next;
        }
    }
    return span(p, jounce_breaks_up_to(p, t));
}

static uint64_t bits_of(double x) {
    jounce_bits both;
    both.number = x;
    return both.bits;
}

/* A whole tile of times since the start of a piece; 0 unless all lie within low <= t < high. Signs
 * of differences tell, which a processor takes several at a time; NaN and infinity fail too. */
WIDE static int whole_tile(const Span *s, const double *restrict t, double *restrict tau) {
    double low = s->low, high = smaller(s->high, LARGEST), origin = s->origin;
    double longest = s->longest;
    uint64_t before = 0, inside = ~(uint64_t)0;
    int i;
    for (i = 0; i < TILE; i++) {
        before |= bits_of(t[i] - low);
        inside &= bits_of(t[i] - high);
        tau[i] = smaller(t[i] - origin, longest);
    }
    return before >> 63 == 0 && inside >> 63 == 1;
}

/* Horner's rule on a tile, two powers at a time. */
WIDE static void a_tile(const double *restrict c, int degree, const double *restrict tau,
                        double *restrict value) {
    int i, j = degree - 1;
    double top = c[degree], next = degree > 0 ? c[degree - 1] : 0.0, last;
    if (degree == 0) {
        for (i = 0; i < TILE; i++) {
            value[i] = top;
        }
    } else if (degree % 2 != 0) {
        for (i = 0; i < TILE; i++) {
            value[i] = top * tau[i] + next;
        }
    } else {
        j--;
        last = c[j];
        for (i = 0; i < TILE; i++) {
            value[i] = (top * tau[i] + next) * tau[i] + last;
        }
    }
    for (j--; j > 0; j -= 2) {
        next = c[j];
        last = c[j - 1];
        for (i = 0; i < TILE; i++) {
            value[i] = (value[i] * tau[i] + next) * tau[i] + last;
        }
    }
}

static void a_few(const double *c, int degree, const double *tau, size_t count, double *value) {
    size_t i;
    for (i = 0; i < count; i++) {
        value[i] = horner(c, degree, tau[i]);
    }
}

/* Up to a tile of times since the start of a piece. */
static void on_piece(const double *state, int order, int k, const double *tau, size_t count,
                     double *out) {
    double c[JOUNCE_MOST_ORDER + 1], value[TILE];
    int degree = order - k;
    size_t i;
    jounce_coefficients(state + k, degree, c);
    if (count == TILE) {
        a_tile(c, degree, tau, out);
    } else if (count <= SHORT) {
        a_few(c, degree, tau, count, out);
    } else {
        a_tile(c, degree, tau, value);
        for (i = 0; i < count; i++) {
            out[i] = value[i];
        }
    }
}

/* The times from t on that lie in a span, at most a tile, as times since its start. */
static size_t run(const Span *s, const double *t, size_t left, double *tau) {
    size_t most = left < TILE ? left : TILE, n;
    if (left >= TILE && whole_tile(s, t, tau)) {
        return TILE;
    }
    for (n = 0; n < most && holds(s, t[n]); n++) {
        tau[n] = smaller(t[n] - s->origin, s->longest);
    }
    return n;
}

jounce_status jounce_evaluate(const jounce_pieces *pieces, const double *times, size_t count,
                              int first, int last, double *out, size_t stride) {
    size_t width = (size_t)pieces->order + 1, done = 0;
    double tau[TILE] = {0};
    Span at = span(pieces, 0);
    while (done < count) {
        const double *state;
        size_t n;
        int k;
        if (!is_finite(times[done])) {
            return JOUNCE_RANGE;
        }
        if (!holds(&at, times[done])) {
            at = find(pieces, &at, times[done]);
        }
        n = run(&at, times + done, count - done, tau);
        state = pieces->states + at.index * width;
        for (k = first; k <= last; k++) {
            double *row = out + (size_t)(k - first) * stride + done;
            if (k <= pieces->order) {
                on_piece(state, pieces->order, k, tau, n, row);
            } else {
                size_t i;
                for (i = 0; i < n; i++) {
                    row[i] = 0.0;
                }
            }
        }
        done += n;
    }
    return JOUNCE_OK;
}
