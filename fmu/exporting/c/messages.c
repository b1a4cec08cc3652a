/* Messages to the host, put together without a C library. */

typedef struct {
    char text[400];
    size_t length;
} Message;

static void add(Message *message, const char *text) {
    for (; *text && message->length + 1 < sizeof message->text; text++) {
        /* both have a meaning in the messages of FMI 2 */
        message->text[message->length++] = (char)(*text == '%' || *text == '#' ? '?' : *text);
    }
    message->text[message->length] = 0;
}

/* Digits 0 to last, a point behind digit `point`. */
static void add_digits(Message *message, const char *digits, int last, int point) {
    char one[2] = {0};
    int i;
    for (i = 0; i <= last || (i <= point && point < 6); i++) {
        if (i == point + 1) {
            add(message, ".");
        }
        one[0] = i <= last ? digits[i] : '0';
        add(message, one);
    }
}

/* Six digits, as printf("%g") writes them. */
static void add_number(Message *message, double number) {
    char digits[7] = {0}, exponent_digits[4] = {0};
    int exponent = 0, last = 5, i;
    long rounded;
    if (number != number) {
        add(message, "NaN");
        return;
    }
    if (number < 0.0) {
        add(message, "-");
        number = -number;
    }
    if (!is_finite(number)) {
        add(message, "infinity");
        return;
    }
    for (; number >= 10.0; exponent++) {
        number /= 10.0;
    }
    for (; number > 0.0 && number < 1.0; exponent--) {
        number *= 10.0;
    }
    rounded = (long)(number * 100000.0 + 0.5);
    if (rounded >= 1000000) {
        rounded /= 10;
        exponent += 1;
    }
    for (i = 5; i >= 0; i--, rounded /= 10) {
        digits[i] = (char)('0' + rounded % 10);
    }
    for (; last > 0 && digits[last] == '0'; last--) {
    }
    if (exponent < -4 || exponent > 5) {
        add_digits(message, digits, last, 0);
        add(message, exponent < 0 ? "e-" : "e");
        exponent = exponent < 0 ? -exponent : exponent;
        i = 0;
        if (exponent >= 100) {
            exponent_digits[i++] = (char)('0' + exponent / 100);
        }
        if (exponent >= 10) {
            exponent_digits[i++] = (char)('0' + exponent / 10 % 10);
        }
        exponent_digits[i] = (char)('0' + exponent % 10);
        add(message, exponent_digits);
        return;
    }
    if (exponent < 0) {
        add(message, "0.");
        for (; exponent < -1; exponent++) {
            add(message, "0");
        }
        add_digits(message, digits, last, 6);
        return;
    }
    add_digits(message, digits, last, exponent);
}
