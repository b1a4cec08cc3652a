/* Pieces of polynomials of any order at many times.
 *
 * Derivative k on a piece is the sum over j >= k of state[j] tau^(j-k) / (j-k)!, by Horner's rule
 * with the inverse factorials multiplied into the state. Times are taken in runs within one piece,
 * so that increasing ones need no search.
 */
#include "jounce.h"
#include "numeric.h"

enum { TILE = 64, SHORT = 8 };

#define LARGEST 1.7976931348623157e308

/* Compiled twice, for the processor's wider registers too: the bits are the same. */
#if defined(__GNUC__) && defined(__x86_64__) && defined(__GLIBC__)
#define WIDE __attribute__((target_clones("avx2", "default")))
#else
#define WIDE
#endif

static const double INVERSE_FACTORIAL[JOUNCE_MOST_ORDER + 1] = {
    1.0, 1.0, 0.5, 0.16666666666666666, 0.041666666666666664, 0.008333333333333333,
    0.001388888888888889, 0.0001984126984126984, 2.48015873015873e-05, 2.7557319223985893e-06,
    2.755731922398589e-07, 2.505210838544172e-08, 2.08767569878681e-09, 1.6059043836821613e-10,
    1.1470745597729725e-11, 7.647163731819816e-13, 4.779477332387385e-14, 2.8114572543455206e-15,
    1.5619206968586225e-16, 8.22063524662433e-18, 4.110317623312165e-19, 1.9572941063391263e-20,
    8.896791392450574e-22, 3.868170170630684e-23, 1.6117375710961184e-24, 6.446950284384474e-26,
    2.4795962632247976e-27, 9.183689863795546e-29, 3.279889237069838e-30, 1.1309962886447716e-31,
    3.7699876288159054e-33, 1.216125041553518e-34, 3.8003907548547434e-36, 1.151633562077195e-37,
    3.387157535521162e-39, 9.67759295863189e-41, 2.6882202662866363e-42, 7.265460179153071e-44,
    1.911963205040282e-45, 4.902469756513544e-47, 1.2256174391283858e-48
};

/* One piece of those before, between and after the breaks: its times are low <= t < high. */
typedef struct {
    size_t index;
    double low, high, origin, longest;
} Span;

static Span span(const jounce_pieces *p, size_t index) {
    Span s;
    int outside = index == 0 || index > p->count;
    s.index = index;
    s.low = index == 0 ? -LARGEST : p->breaks[index - 1];
    s.high = index > p->count ? INFINITE : p->breaks[index];
    s.origin = p->breaks[index == 0 ? 0 : index - 1];
    s.longest = outside ? INFINITE : p->durations[index - 1];
    return s;
}

static int holds(const Span *s, double t) { return s->low <= t && t < s->high; }

/* The number of breaks up to t. */
static size_t search(const jounce_pieces *p, double t) {
    size_t low = 0, high = p->count + 1;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (p->breaks[middle] <= t) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

/* The piece of a finite time, the next one first. */
static Span find(const jounce_pieces *p, const Span *before, double t) {
    if (before->index <= p->count) {
        Span next = span(p, before->index + 1);
        if (holds(&next, t)) {
            return next;
        }
    }
    return span(p, search(p, t));
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
    int j;
    for (i = 0; i < count; i++) {
        double sum = c[degree];
        for (j = degree - 1; j >= 0; j--) {
            sum = sum * tau[i] + c[j];
        }
        value[i] = sum;
    }
}

/* Up to a tile of times since the start of a piece. */
static void on_piece(const double *state, int order, int k, const double *tau, size_t count,
                     double *out) {
    double c[JOUNCE_MOST_ORDER + 1], value[TILE];
    int j, degree = order - k;
    size_t i;
    for (j = 0; j <= degree; j++) {
        c[j] = state[k + j] * INVERSE_FACTORIAL[j];
    }
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
