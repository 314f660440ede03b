/* Messages: a text of bounded length that grows at its end, numbers written as Python writes them. */

#ifndef TEXT_H
#define TEXT_H

#include <stddef.h>

#include "model.h"

typedef struct {
    char at[2048];
    size_t length;
} Text;

/* Append in the manner of printf; what does not fit is cut off. */
void text_append(Text *text, const char *format, ...);

/* Append a text as a format of printf that prints it. */
void text_append_format(Text *text, const char *plain);

/* Append a number: the shortest digits that read back as the same double, whatever the locale. */
void text_append_number(Text *text, double value);

/* Append the value of a variable with its unit. */
void text_append_value(Text *text, const Variable *variable, double value);

#endif
