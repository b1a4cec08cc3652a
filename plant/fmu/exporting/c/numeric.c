/* Elementary functions without the C library's mathematics, the same bits on every platform. */

typedef union {
    double number;
    uint64_t bits;
} Double;

static inline int is_finite(double x) {
    return x - x == 0.0;
}

static inline double power_of_two(int exponent) { /* of a normal number: -1022 to 1023 */
    Double result;
    result.bits = (uint64_t)(exponent + 1023) << 52;
    return result.number;
}

static inline double magnitude(double x) {
    return x < 0.0 ? -x : x;
}

static inline double smaller(double a, double b) {
    return b < a ? b : a;
}

static inline double larger(double a, double b) {
    return b > a ? b : a;
}

/* Correctly rounded: by the processor where it has an instruction, else digit by digit. */
#if defined(__GNUC__) && defined(__x86_64__) && !defined(BY_DIGITS)
static inline double square_root(double x) {
    double root;
    __asm__("sqrtsd %1, %0" : "=x"(root) : "x"(x));
    return root;
}
#elif defined(__GNUC__) && defined(__aarch64__) && !defined(BY_DIGITS)
static inline double square_root(double x) {
    double root;
    __asm__("fsqrt %d0, %d1" : "=w"(root) : "w"(x));
    return root;
}
#else
static inline double square_root(double x) {
    Double value;
    uint64_t whole, root = 0, rest = 0;
    int exponent, i;
    if (!(x > 0.0) || !is_finite(x)) {
        return x < 0.0 ? (x - x) / (x - x) : x;
    }
    value.number = x < 1e-290 ? x * 18014398509481984.0 : x; /* times 2^54: no longer subnormal */
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

static inline double exponential(double x) {
    double r, sum = 1.0;
    int k, j;
    if (!(x > -745.2)) {
        return x != x ? x : 0.0;
    }
    if (x > 709.79) {
        return 1e308 * 10.0;
    }
    k = (int)(x * 1.4426950408889634 + (x < 0.0 ? -0.5 : 0.5));
    r = (x - k * 6.93147180369123816490e-01) - k * 1.90821492927058770002e-10;
    for (j = 14; j > 0; j--) {
        sum = 1.0 + sum * r / j;
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
