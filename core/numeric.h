/* Numbers: what C99 leaves to libm, and constants of rounding; the same bits everywhere. */
#ifndef JOUNCE_NUMERIC_H
#define JOUNCE_NUMERIC_H

#include <stdint.h>

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__) && defined(__FP_FAST_FMA)
#pragma GCC optimize("fp-contract=off") /* it does not know the standard's pragma */
#elif defined(_MSC_VER)
#pragma fp_contract(off)
#endif

#define EPSILON 2.220446049250313e-16 /* 2^-52 */
#define ROUNDING 3.552713678800501e-15 /* relative size below which a difference is rounding */
#define INFINITE ((double)1e300 * (double)1e300)

typedef union {
    double number;
    uint64_t bits;
} jounce_bits;

static inline double magnitude(double x) {
#if defined(__GNUC__)
    return __builtin_fabs(x); /* an instruction, not a call */
#else
    return x < 0.0 ? -x : x;
#endif
}

static inline double smaller(double a, double b) { return b < a ? b : a; }

static inline double larger(double a, double b) { return b > a ? b : a; }

static inline double clamp(double x, double low, double high) {
    return smaller(larger(x, low), high);
}

/* The largest whole number up to x. */
static inline double whole_below(double x) {
    double whole;
    if (!(magnitude(x) < 4503599627370496.0)) { /* 2^52: it is whole already */
        return x;
    }
    whole = (double)(int64_t)x;
    return whole > x ? whole - 1.0 : whole;
}

static inline int is_finite(double x) { return x - x == 0.0; }

/* Whether 2^exponent is a normal number, so that products with it round once at most. */
static inline int is_normal(int exponent) { return exponent >= -1022 && exponent <= 1023; }

/* 2^exponent, a normal number. */
static inline double normal_power(int exponent) {
    jounce_bits result;
    result.bits = (uint64_t)(exponent + 1023) << 52;
    return result.number;
}

/* 2^exponent, rounded to zero below and to infinity above the range of a double. */
static inline double power_of_two(int exponent) {
    jounce_bits result;
    if (exponent < -1074) {
        return 0.0;
    }
    if (exponent > 1023) {
        return INFINITE;
    }
    if (exponent >= -1022) {
        return normal_power(exponent);
    }
    result.bits = (uint64_t)1 << (exponent + 1074);
    return result.number;
}

/* The exponent e of a finite x with 2^(e-1) <= |x| < 2^e; -1100 for zero. */
static inline int exponent_of(double x) {
    jounce_bits value;
    int scaled = 0;
    value.number = magnitude(x);
    if (value.bits < (uint64_t)1 << 52) { /* zero, or subnormal */
        if (value.bits == 0) {
            return -1100;
        }
        value.number *= 18014398509481984.0;
        scaled = 54;
    }
    return (int)(value.bits >> 52) - 1022 - scaled;
}

/* x * 2^exponent, rounded once. */
static inline double scaled(double x, int exponent) {
    int own;
    if (is_normal(exponent)) {
        return x * normal_power(exponent);
    }
    if (x == 0.0 || !is_finite(x)) {
        return x;
    }
    own = exponent_of(x);
    x *= power_of_two(-own / 2);
    x *= power_of_two(-own - -own / 2); /* 0.5 <= |x| < 1 */
    exponent = exponent + own < -1080 ? -1080 : exponent + own;
    if (exponent > 1024) {
        return x > 0.0 ? INFINITE : -INFINITE;
    }
    return x * power_of_two(exponent / 2) * power_of_two(exponent - exponent / 2);
}

/* Correctly rounded: by the processor where it has an instruction, else digit by digit. */
#if defined(__GNUC__) && defined(__x86_64__) && !defined(JOUNCE_BY_DIGITS)
static inline double square_root(double x) {
    double root;
    __asm__("sqrtsd %1, %0" : "=x"(root) : "x"(x));
    return root;
}
#elif defined(__GNUC__) && defined(__aarch64__) && !defined(JOUNCE_BY_DIGITS)
static inline double square_root(double x) {
    double root;
    __asm__("fsqrt %d0, %d1" : "=w"(root) : "w"(x));
    return root;
}
#else
static inline double square_root(double x) {
    jounce_bits value;
    uint64_t whole, root = 0, rest = 0;
    int exponent, i;
    if (!(x > 0.0) || !is_finite(x)) {
        return x < 0.0 ? (x - x) / (x - x) : x;
    }
    value.number = x < 1e-290 ? x * 18014398509481984.0 : x; /* 2^54: no longer subnormal */
    exponent = (int)(value.bits >> 52) - 1075 - (x < 1e-290 ? 54 : 0);
    whole = (value.bits & 0xfffffffffffffu) | 0x10000000000000u;
    if (exponent % 2 != 0) {
        whole <<= 1;
        exponent -= 1;
    }
    for (i = 0; i < 54; i++) { /* of whole * 2^54, two binary digits at a time */
        uint64_t next = (root << 2) | 1;
        rest = (rest << 2) | (i < 27 ? (whole >> (52 - 2 * i)) & 3 : 0);
        root <<= 1;
        if (rest >= next) {
            rest -= next;
            root |= 1;
        }
    }
    return (double)((root >> 1) + (root & 1)) * power_of_two(exponent / 2 - 26);
}
#endif

/* The cube root, to about an ulp: a parabola within 1.6 %, then Halley's iteration twice. */
static inline double cube_root(double x) {
    int exponent, third, i;
    double y, size = magnitude(x);
    if (size == 0.0 || !is_finite(size)) {
        return x;
    }
    exponent = exponent_of(size);
    third = (exponent + 3002) / 3 - 1000; /* of 3000, which keeps it positive */
    size = scaled(size, -3 * third); /* 1/8 <= size < 1 */
    y = 0.381250062902365 + (1.0723052018930965 - 0.46946103060149097 * size) * size;
    for (i = 0; i < 2; i++) {
        double cube = y * y * y;
        y -= y * (cube - size) / (2.0 * cube + size);
    }
    y = scaled(y, third);
    return x < 0.0 ? -y : y;
}

/* How far a function goes to zero, which is `error` with derivative `slope` here and known a `step`
 * away, where it has the other sign: by a cubic of the inverse, or a secant where that cannot tell. */
static inline double step_to_zero(double step, double error, double slope, double other_error,
                                  double other_slope) {
    double gain = other_error - error, part = -error / gain, rest = 1.0 - part, bend;
    if (!(slope * other_slope > 0.0 && slope * gain * step > 0.0)) {
        return step * part;
    }
    bend = part * rest * ((gain / slope - step) * rest - (gain / other_slope - step) * part);
    return step * part + (magnitude(bend) < magnitude(step) * smaller(part, rest) ? bend : 0.0);
}

/* e^x, to about an ulp. */
static inline double exponential(double x) {
    double r, sum = 1.0;
    int k, j;
    if (!(x > -745.2)) {
        return x != x ? x : 0.0;
    }
    if (x > 709.79) {
        return INFINITE;
    }
    k = (int)(x * 1.4426950408889634 + (x < 0.0 ? -0.5 : 0.5));
    r = (x - (double)k * 6.93147180369123816490e-01) - (double)k * 1.90821492927058770002e-10;
    for (j = 14; j > 0; j--) {
        sum = 1.0 + sum * r / (double)j;
    }
    return sum * power_of_two(k / 2) * power_of_two(k - k / 2);
}

/* x less the nearest multiple of p > 0, exactly; of two the even one, as IEEE 754 remainder. */
static inline double nearest_remainder(double x, double p) {
    double rest = magnitude(x), part = p;
    int odd = 0;
    if (!is_finite(rest)) {
        return x - x;
    }
    while (part <= 0.5 * rest) {
        part += part;
    }
    for (;;) {
        odd = 0;
        if (rest >= part) {
            rest -= part;
            odd = 1;
        }
        if (part <= p) {
            break;
        }
        part *= 0.5;
    }
    if (rest > p - rest || (rest == p - rest && odd)) {
        rest -= p;
    }
    return x < 0.0 ? -rest : rest;
}

/* x less the multiple of p > 0 next to it towards zero, exactly, as C's fmod. */
static inline double truncated_remainder(double x, double p) {
    double rest = nearest_remainder(magnitude(x), p);
    rest = rest < 0.0 ? rest + p : rest;
    return x < 0.0 ? -rest : rest;
}

#endif
