/* SPDX-License-Identifier: MIT */
/*
 * reason_text.c - the names of classes, and reasons as English clauses
 *
 * A reason is a template and a number: '%' stands for the number as a percentage, '#' for the
 * number with two decimals.  Numbers are formatted here because snprintf depends on the locale.
 */
#include "base/view.h"

#include <string.h>

enum { CLASS_COUNT = NTP_CLASS_NOT_NORMALS + 1, TEXT_COUNT = NTP_REASON_ZZERO_MEANS + 1 };

/* In the order of ntp_class. */
static const char CLASS_NAMES[] =
    "standard\0zzero\0xy\0height\0object-space\0one-color\0not-normals\0";

/* In the order of NTP_REASON_*, each with its end: pointers to them would be as many bytes again. */
static const char TEXTS[] =
    "there is no evidence for it\0"
    "every texel is black, white or transparent\0"
    "all used texels have one color\0"
    "% of the used texels are gray\0"
    "the image is gray\0"
    "there are only red and green\0"
    "% of the used texels are unit vectors to within a level\0"
    "% of the used texels are unit vectors to within a level when blue is read as 0..1\0"
    "% of the used texels have about unit length\0"
    "% of the used texels have about unit length when blue is read as 0..1\0"
    "only % of the used texels have about unit length\0"
    "blue matches red and green as -1..1, not as 0..1, in % of the texels that can tell\0"
    "blue matches red and green as 0..1, not as -1..1, in % of the texels that can tell\0"
    "blue fits -1..1 and 0..1 about equally well\0"
    "red and green lie around the middle; their mean is off by #\0"
    "red and green do not lie around the middle; their mean is off by #\0"
    "x and y are longer than 1 in % of the used texels\0"
    "blue is the same in all used texels, % of its range\0"
    "blue is the z of red and green in only % of the tilted texels\0"
    "z is negative in % of the used texels\0"
    "normals point in all directions; z is negative in % of the used texels\0"
    "decoded from sRGB, % of the used texels have about unit length\0"
    "% of the used texels lie near the level 188, which is flat stored as sRGB\0"
    "red is above one half in % of the used texels, as z is\0"
    "green is above one half in % of the used texels, as z is\0"
    "alpha and green, taken for x and y, are not too long in % of the used texels\0"
    "color steps are # times as large at every eighth column as elsewhere, as in JPEG blocks\0"
    "% of the used texels are too short, and hardly any is too long\0"
    "red and green vary together, with a correlation of #, as the colors of a picture do\0"
    "every used texel is a correctly rounded unit vector\0"
    "the file format is lossy\0"
    "all three channels are off: the length error of steep texels is # times that of shallow ones\0"
    "only blue is off: the length error of steep texels is # times that of shallow ones\0"
    "blue is far off in % of the used texels, and the others are right\0"
    "blue is not z\0"
    "it is so flat that deriving and normalizing give about the same result\0"
    "% of the used texels are too long, and hardly any is too short, which only a wrong blue "
    "causes\0"
    "all three channels vary together, with a correlation of #, as after lossy compression\0"
    "blue varies with the z of red and green, with a correlation of #\0"
    "against it: red and green vary together, with a correlation of #, as the colors of a picture "
    "do\0"
    "blue hardly varies around % of its range, and not with the z of red and green\0"
    "blue varies with red or green, with a correlation of #, as the colors of a picture do\0"
    "red, green and blue are spread alike around % of their range, as noise is\0"
    "on average blue lies # times as far below its end as the z of red and green does in -1..1; it "
    "is 2 times in 0..1\0";

typedef struct buffer {
    char *text;
    size_t size, length;
} buffer;

static void put(buffer *b, char c)
{
    if (b->length + 1 < b->size)
        b->text[b->length] = c;
    b->length++;
}

/* Puts value, rounded to `decimals` (0 to 2) places.  NaN and values beyond the limit are put as
 * the limit. */
static void put_number(buffer *b, double value, int32_t decimals)
{
    const double limit = 1e9;
    uint64_t unit = decimals == 2 ? 100 : decimals == 1 ? 10 : 1;
    if (value < 0) {
        put(b, '-');
        value = -value;
    }
    if (!(value < limit))
        value = limit;
    uint64_t scaled = (uint64_t) (value * (double) unit + 0.5), divisor = 1;
    uint64_t whole = scaled / unit, rest = scaled % unit;
    while (whole / divisor >= 10)
        divisor *= 10;
    for (; divisor > 0; divisor /= 10)
        put(b, (char) ('0' + whole / divisor % 10));
    if (decimals > 0)
        put(b, '.');
    for (divisor = unit / 10; divisor > 0; divisor /= 10)
        put(b, (char) ('0' + rest / divisor % 10));
}

/* Puts a share in percent.  A share between none and all never reads as "0 %" or "100 %". */
static void put_percent(buffer *b, double share)
{
    double percent = 100 * share;
    if (percent > 0 && percent < 0.1) {
        put(b, '<');
        percent = 0.1;
    } else if (percent < 100 && percent > 99.9) {
        put(b, '>');
        percent = 99.9;
    }
    put_number(b, percent, percent == 0 || percent == 100 ? 0 : 1);
    put(b, ' ');
    put(b, '%');
}

/* The i-th of strings that lie one behind the other, each with its end. */
static const char *string_at(const char *strings, int32_t i)
{
    for (; i > 0; i--)
        strings += strlen(strings) + 1;
    return strings;
}

size_t ntp_reason_text(char *text, size_t size, const ntp_reason *reason)
{
    buffer b = { text, text == NULL ? 0 : size, 0 };
    const bool known = reason != NULL && reason->code >= 0 && reason->code < TEXT_COUNT;
    for (const char *c = string_at(TEXTS, known ? reason->code : 0); *c != '\0'; c++) {
        if (*c == '%')
            put_percent(&b, reason->value);
        else if (*c == '#')
            put_number(&b, reason->value, 2);
        else
            put(&b, *c);
    }
    if (b.size > 0)
        b.text[b.length < b.size ? b.length : b.size - 1] = '\0';
    return b.length;
}

const char *ntp_class_name(ntp_class type)
{
    return (int) type >= 0 && (int) type < CLASS_COUNT ? string_at(CLASS_NAMES, (int) type)
                                                       : "unknown";
}
