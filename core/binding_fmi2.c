/* Messages of FMI 2.0's logger, which is variadic as Python's callbacks cannot be, as plain text.
 *
 * A message whose format is not one of C is passed on as it stands, so that a lone "%" does no
 * harm: "50 % slower" has no arguments. So is one with %n, which writes.
 */
#include "binding_fmi2.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { LONGEST = 4096 };

/* An FMU that does not give back the environment that it was given is heard nevertheless. */
static jounce_fmi2_note for_strays;

static const char *past(const char *text, const char *set) { return text + strspn(text, set); }

/* The end of a conversion that begins behind its "%", or NULL where C knows none such. */
static const char *conversion(const char *text) {
    const char *flags = text, *end = past(text, "-+ #0");
    int spaced = memchr(flags, ' ', (size_t)(end - flags)) != NULL;
    end = past(end, "0123456789");
    if (*end == '.') {
        end = past(end + 1, "0123456789");
    }
    end = past(end, "hlLjzt");
    if (*end == '%') {
        return end == text ? end + 1 : NULL;
    }
    if (*end == '\0' || strchr(spaced ? "dieEfFgGaA" : "dieEfFgGaAuoxXcsp", *end) == NULL) {
        return NULL;
    }
    return end + 1;
}

static int is_format(const char *text) {
    for (text = strchr(text, '%'); text != NULL; text = strchr(text, '%')) {
        text = conversion(text + 1);
        if (text == NULL) {
            return 0;
        }
    }
    return 1;
}

static void log_message(void *environment, const char *name, int status, const char *category,
                        const char *message, ...) {
    const jounce_fmi2_environment *own = environment;
    jounce_fmi2_note note = for_strays;
    char text[LONGEST];
    (void)name;
    if (own != NULL && own->mark == JOUNCE_FMI2_MARK) {
        note = own->note;
    }
    if (message != NULL && is_format(message)) {
        va_list arguments;
        va_start(arguments, message);
        vsnprintf(text, sizeof text, message, arguments);
        va_end(arguments);
        message = text;
    }
    note(status, category, message);
}

jounce_fmi2_logger jounce_fmi2_log_to(jounce_fmi2_note strays) {
    for_strays = strays;
    return log_message;
}
