/* SPDX-License-Identifier: MIT */
/*
 * verb_dump.c - ntp dump: texels as CSV
 *
 * The file is read twice: first to find out what it is, then to print.
 */
#include <string.h>

#include "report/report.h"
#include "verbs/verbs.h"
#include "write/refusal.h"

typedef struct dump {
    const options *o;
    source s;
    facts f;
    uint32_t pass_bit; /* NTP_FLAG_*: of the verdict */
    bool all, keep_negative_z;
} dump;

static void header(const dump *d)
{
    text t = { 0 };
    text_addf(&t,
              "column,row,r,g,b%s,x,y,z,length,flags,levels_off,clean_r,clean_g,clean_b,angle\n",
              d->s.view.channels == 4 ? ",a" : "");
    output_text(&t);
    text_free(&t);
}

static void add_flags(text *t, uint32_t flags)
{
    static const struct {
        uint32_t bit;
        bool when;
        const char *name;
    } FLAGS[] = {
        { NTP_FLAG_NEIGHBOR, false, "not_neighbor" }, { NTP_FLAG_ROUNDED, false, "not_rounded" },
        { NTP_FLAG_EXACT, false, "not_exact" },       { NTP_FLAG_XY_TOO_LONG, true, "xy_too_long" },
        { NTP_FLAG_Z_NEGATIVE, true, "z_negative" },  { NTP_FLAG_UNUSED, true, "unused" },
        { NTP_FLAG_NOT_FINITE, true, "not_finite" },
    };
    const char *separator = "";
    for (size_t i = 0; i < sizeof FLAGS / sizeof FLAGS[0]; i++) {
        if (((flags & FLAGS[i].bit) != 0) != FLAGS[i].when)
            continue;
        text_addf(t, "%s%s", separator, FLAGS[i].name);
        separator = " ";
    }
}

static void add_row(text *t, const ntp_texel *v, int32_t column, int32_t row, int32_t channels)
{
    text_addf(t, "%d,%d,%u,%u", (int) column, (int) row, (unsigned) v->stored[0],
              (unsigned) v->stored[1]);
    for (int32_t c = 2; c < 4; c++) {
        if (c < channels || c == 2)
            text_addf(t, ",%u", (unsigned) v->stored[c]);
    }
    text_addf(t, ",%.6f,%.6f,%.6f,%.6f,", v->x, v->y, v->z, v->length);
    add_flags(t, v->flags);
    text_char(t, ',');
    if (v->levels_off >= 0)
        text_addf(t, "%d", (int) v->levels_off);
    text_addf(t, ",%u,%u,%u,%.6f\n", (unsigned) v->cleaned[0], (unsigned) v->cleaned[1],
              (unsigned) v->cleaned[2], v->angle);
}

static bool print_area(const dump *d, const ntp_rect *area, ntpio_error *error)
{
    const ntp_const_image view = ntp_image_as_const(&d->s.view);
    text t = { 0 };
    ntp_status status = NTP_OK;
    for (int32_t y = area->y0; status == NTP_OK && y < area->y1; y++) {
        for (int32_t x = 0; status == NTP_OK && x < area->x1; x++) {
            ntp_texel texel;
            status = ntp_inspect(&texel, &view, x, y, d->keep_negative_z);
            if (status == NTP_OK && (d->all || (texel.flags & d->pass_bit) == 0))
                add_row(&t, &texel, x, y, view.channels);
        }
    }
    output_text(&t);
    text_free(&t);
    return status == NTP_OK || library_error(&d->s, status, error);
}

static unsigned run(dump *d, ntpio_error *error)
{
    if (!examine(&d->s, forced_class(d->o), &d->f, error))
        return RAN_FAILED;
    const bool pair = d->f.encoding == NTP_ENCODING_XY; /* of gray and alpha */
    if ((d->s.view.channels < 3 && !(pair && d->f.forced)) ||
        (d->f.forced && d->f.encoding == NTP_ENCODING_HEIGHT)) {
        text t = { 0 };
        if (pair)
            add_refusal(&t, &d->f, "type");
        else
            text_add(&t,
                     "a height map has no normals to list; --type standard takes it for a texture");
        complain("%s: %s", d->s.in->path, text_string(&t));
        text_free(&t);
        return RAN_FINDINGS;
    }
    if (d->s.view.encoding == NTP_ENCODING_HEIGHT)
        d->s.view.encoding = NTP_ENCODING_STANDARD;
    if (!source_rewind(&d->s, error))
        return RAN_FAILED;
    header(d);
    ntp_rect area;
    int more;
    while ((more = source_next(&d->s, &area, error)) > 0) {
        if (!print_area(d, &area, error))
            return RAN_FAILED;
        if (output_closed() || output_failed())
            return 0;
    }
    return more == 0 ? 0 : RAN_FAILED;
}

int dump_run(const options *o)
{
    static const uint32_t PASS_BITS[] = { NTP_FLAG_NEIGHBOR, NTP_FLAG_ROUNDED, NTP_FLAG_EXACT };
    if (o->path_count != 1) {
        complain("ntp dump takes one file");
        return NTP_EXIT_USAGE;
    }
    dump d = { .o = o,
               .pass_bit = PASS_BITS[option_integer(o, OPT_VERDICT)],
               .all = option_given(o, OPT_ALL),
               .keep_negative_z = option_given(o, OPT_KEEP_NEGATIVE_Z) };
    const input in = { .path = o->paths[0], .named = true };
    const ntpio_limits limits = limits_from(o);
    ntpio_error error = { 0 };
    worker *w = worker_new();
    unsigned ran = RAN_FAILED;
    if (source_open(&d.s, w, &in, &limits, &error)) {
        ran = run(&d, &error);
        source_close(&d.s);
    }
    if (interrupted_by != 0)
        ran = RAN_INTERRUPTED;
    else if (ran == RAN_FAILED)
        complain("%s", error.message);
    facts_free(&d.f);
    worker_free(w);
    return exit_code(ran);
}
