/* Messages of FMI 2.0's logger, which is variadic as Python's callbacks cannot be, as plain text.
 *
 * A message is passed on as it stands where its format is not one of C, so that a lone "%" does no
 * harm ("50 % slower" has no arguments); where it has %n, which writes, or wide text; and where its
 * arguments cannot be those that it tells of: text that is not in memory, a width beyond reason.
 */
#define _POSIX_C_SOURCE 200112L /* msync */

#include "binding_fmi2.h"

#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#if defined(_WIN32)
#include <windows.h>
#else
#include <sys/mman.h>
#include <unistd.h>
#endif

enum { LONGEST = 4096 };

/* An FMU that does not give back the environment that it was given is heard nevertheless. */
static jounce_fmi2_note for_strays;

/* --- formats ---------------------------------------------------------------------------------- */

enum { ANY_NUMBER = -1, AN_ARGUMENT = -2 };

/* What stands behind a "%": `kind` is the last character, `length` that before it, 'q' for "ll". */
typedef struct {
    char kind, length;
    int width, precision; /* or one of the above */
} Conversion;

static const char *past(const char *text, const char *set) { return text + strspn(text, set); }

/* A number of up to four digits, or "*". */
static const char *size(const char *text, int *number) {
    int digits;
    *number = ANY_NUMBER;
    if (*text == '*') {
        *number = AN_ARGUMENT;
        return text + 1;
    }
    for (digits = 0; digits < 4 && *text >= '0' && *text <= '9'; digits++, text++) {
        *number = 10 * (digits > 0 ? *number : 0) + (*text - '0');
    }
    return text;
}

static const char *length_of(const char *text, char *length) {
    const char *end = past(text, "hlLjzt");
    int twice = end - text == 2 && text[0] == text[1] && (*text == 'h' || *text == 'l');
    *length = '\0';
    if (end > text) {
        *length = !twice ? *text : *text == 'l' ? 'q' : 'h';
    }
    return end - text > 1 + twice ? NULL : end;
}

/* Whether C knows this kind of this length. */
static int is_known(const Conversion *c) {
    const char *kinds = strchr("hqjzt", c->length) != NULL ? "diuoxX"
                        : c->length == 'l'                 ? "diuoxXeEfFgGaA"
                                                           : "eEfFgGaA";
    return strchr(c->length == '\0' ? "diuoxXeEfFgGaAcsp%" : kinds, c->kind) != NULL;
}

/* Read a conversion behind its "%": its end, or NULL where C knows none such. */
static const char *conversion(const char *text, Conversion *c) {
    const char *flags = text, *end = past(text, "-+ #0");
    int spaced = memchr(flags, ' ', (size_t)(end - flags)) != NULL;
    end = size(end, &c->width);
    c->precision = ANY_NUMBER;
    if (*end == '.') {
        end = size(end + 1, &c->precision);
        c->precision = c->precision == ANY_NUMBER ? 0 : c->precision;
    }
    end = length_of(end, &c->length);
    if (end == NULL || *end == '\0') {
        return NULL;
    }
    c->kind = *end;
    if (!is_known(c) || (c->kind == '%' && end != text) ||
        (spaced && strchr("uoxXcsp", c->kind) != NULL)) {
        return NULL;
    }
    return end + 1;
}

/* --- arguments ---------------------------------------------------------------------------------- */

/* Whether there is memory at an address; a page that must not be read is not told apart. */
static int is_there(const char *at) {
#if defined(_WIN32)
    return !IsBadReadPtr(at, 1);
#else
    size_t page = (size_t)sysconf(_SC_PAGESIZE);
    return msync((void *)((uintptr_t)at / page * page), page, MS_ASYNC) == 0;
#endif
}

/* Whether text ends, or reaches `most` characters, in memory that is there; NULL is printed. */
static int is_text(const char *text, int most) {
    enum { CHECKED = 4096 }; /* no page is smaller */
    int i;
    for (i = 0; text != NULL && i != most; i++) {
        if ((i == 0 || (uintptr_t)(text + i) % CHECKED == 0) && !is_there(text + i)) {
            return 0;
        }
        if (text[i] == '\0') {
            return 1;
        }
    }
    return 1;
}

/* Take what a conversion takes; 0 for what cannot be its argument. */
static int takes(const Conversion *c, va_list *arguments) {
    int width = c->width == AN_ARGUMENT ? va_arg(*arguments, int) : 0;
    int precision = c->precision == AN_ARGUMENT ? va_arg(*arguments, int) : c->precision;
    if (width < -LONGEST || width > LONGEST || precision > LONGEST) {
        return 0;
    }
    if (c->kind == 's') {
        return is_text(va_arg(*arguments, const char *), precision);
    }
    if (c->kind == 'p') {
        (void)va_arg(*arguments, void *);
    } else if (strchr("eEfFgGaA", c->kind) != NULL) {
        c->length == 'L' ? (void)va_arg(*arguments, long double)
                         : (void)va_arg(*arguments, double);
    } else if (c->length == 'l') {
        (void)va_arg(*arguments, long);
    } else if (c->length == 'q') {
        (void)va_arg(*arguments, long long);
    } else if (c->length == 'j') {
        (void)va_arg(*arguments, intmax_t);
    } else if (c->length == 'z') {
        (void)va_arg(*arguments, size_t);
    } else if (c->length == 't') {
        (void)va_arg(*arguments, ptrdiff_t);
    } else if (c->kind != '%') {
        (void)va_arg(*arguments, int);
    }
    return 1;
}

/* Whether C knows the format, and these can be its arguments. */
static int is_format(const char *text, va_list *arguments) {
    Conversion c;
    for (text = strchr(text, '%'); text != NULL; text = strchr(text, '%')) {
        text = conversion(text + 1, &c);
        if (text == NULL || !takes(&c, arguments)) {
            return 0;
        }
    }
    return 1;
}

/* --- the logger --------------------------------------------------------------------------------- */

static void log_message(void *environment, const char *name, int status, const char *category,
                        const char *message, ...) {
    const jounce_fmi2_environment *own = environment;
    jounce_fmi2_note note = for_strays;
    char text[LONGEST];
    (void)name;
    if (own != NULL && own->mark == JOUNCE_FMI2_MARK) {
        note = own->note;
    }
    if (message != NULL) {
        va_list arguments, tried;
        va_start(arguments, message);
        va_copy(tried, arguments);
        if (is_format(message, &tried) &&
            vsnprintf(text, sizeof text, message, arguments) >= 0) {
            message = text;
        }
        va_end(tried);
        va_end(arguments);
    }
    note(status, category, message);
}

jounce_fmi2_logger jounce_fmi2_log_to(jounce_fmi2_note strays) {
    for_strays = strays;
    return log_message;
}
