#include "text.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_DIGITS = 17 };

void text_append(Text *text, const char *format, ...) {
    const size_t room = sizeof text->at - text->length;
    va_list arguments;
    va_start(arguments, format);
    const int written = vsnprintf(text->at + text->length, room, format, arguments);
    va_end(arguments);
    if (written > 0) {
        text->length += (size_t)written < room ? (size_t)written : room - 1;
    }
}

void text_append_format(Text *text, const char *plain) {
    for (const char *c = plain; *c != '\0'; c++) {
        text_append(text, *c == '%' ? "%%%%" : "%c", *c);
    }
}

/* Digits without sign and point, and the decimal exponent of the first one; returns their count. */
static int shortest_digits(double magnitude, char digits[MOST_DIGITS + 1], int *exponent) {
    char written[40];
    for (int n = 1; n <= MOST_DIGITS; n++) {
        snprintf(written, sizeof written, "%.*e", n - 1, magnitude);
        if (strtod(written, NULL) == magnitude) {
            break;
        }
    }
    int count = 0;
    const char *c = written;
    for (; *c != 'e' && *c != '\0'; c++) {
        if (*c >= '0' && *c <= '9' && count < MOST_DIGITS) {
            digits[count++] = *c;
        }
    }
    digits[count] = '\0';
    *exponent = *c == 'e' ? atoi(c + 1) : 0;
    return count;
}

static void append_decimal(Text *text, const char *digits, int count, int exponent) {
    if (exponent < 0) {
        text_append(text, "0.%.*s%s", -exponent - 1, "000000000000000000", digits);
    } else if (exponent + 1 >= count) {
        text_append(text, "%s%.*s.0", digits, exponent + 1 - count, "000000000000000000");
    } else {
        text_append(text, "%.*s.%s", exponent + 1, digits, digits + exponent + 1);
    }
}

void text_append_number(Text *text, double value) {
    if (isnan(value)) {
        text_append(text, "nan");
        return;
    }
    text_append(text, signbit(value) ? "-" : "");
    if (isinf(value)) {
        text_append(text, "inf");
        return;
    }
    char digits[MOST_DIGITS + 1];
    int exponent;
    const int count = shortest_digits(fabs(value), digits, &exponent);
    if (exponent >= -4 && exponent < 16) {
        append_decimal(text, digits, count, exponent);
    } else {
        text_append(text, "%c%s%se%c%02d", digits[0], count > 1 ? "." : "", digits + 1,
                    exponent < 0 ? '-' : '+', abs(exponent));
    }
}

void text_append_value(Text *text, const Variable *variable, double value) {
    if (variable->type == TYPE_BOOLEAN && isfinite(value)) {
        text_append(text, value != 0.0 ? "True" : "False");
    } else if (variable->type != TYPE_REAL && isfinite(value)) {
        text_append(text, "%.0f", value);
    } else {
        text_append_number(text, value);
    }
    text_append(text, "%s", variable->unit);
}
