/* SPDX-License-Identifier: MIT */
/*
 * float_rows_tmpl.h - a part of gradient.c: blocks whose normals are floats
 */

/* Do texels of the result lie side by side as the loop writes them? */
static bool can_pack_floats(const walk *w)
{
    const ntp_image *dst = w->g.dst;
    return dst->channels == 3 && dst->encoding != NTP_ENCODING_XY &&
           dst->pixel_stride == 3 * (ptrdiff_t) sizeof(float);
}

/* Makes the floats of a block by the loop.  at: the places of texels in doubt; returns how many there are. */
static int32_t encode_floats(walk *w, strip *s, float *d, int32_t *at, int32_t x, int32_t y,
                             int32_t n)
{
    if (w->quick) {
        const float *rows[3];
        const facts of_rows = rows_of_heights(w, s, rows, x, y, n);
        const void *const from[3] = { rows[0], rows[1], rows[2] };
        if (!w->floats || trust_floats(w, &of_rows)) {
            const int32_t found = w->encode_vectors(
                d, at, from, w->ints ? NTP__FROM_INTEGERS : NTP__FROM_FLOATS, n, &w->encode);
            if (w->ints)
                sums_of_places(w, s, rows, at, found);
            return found;
        }
    }
    const facts f = all_tap_sums(w, s, x, y, n);
    if (w->floats ? !trust_floats(w, &f) : !w->doubles) {
        for (int32_t i = 0; i < n; i++)
            at[i] = i;
        return n;
    }
    const void *const from[3] = { w->ints ? (const void *) s->sums.i[0] : s->sums.d[0],
                                  w->ints ? (const void *) s->sums.i[1] : s->sums.d[1] };
    return w->encode_vectors(d, at, from, w->ints ? NTP__FROM_SUMS_I : NTP__FROM_SUMS_D, n,
                             &w->encode);
}

static void settle_float(walk *w, const strip *s, float *d, int32_t x, int32_t y, int32_t i)
{
    ntp__normal normal;
    settle_exactly(w, s, &normal, x, y, i);
    memcpy(d + 3 * i, normal.value, sizeof normal.value);
}

static void do_float_block(walk *w, strip *s, int32_t x, int32_t y, int32_t n)
{
    float line[3 * NTP__BLOCK], *const d = w->packed ? ntp__at_mut(w->g.dst, x, y) : line;
    int32_t at[NTP__BLOCK];
    const int32_t found = encode_floats(w, s, d, at, x, y, n);
    for (int32_t i = 0; i < found; i++) {
        if (!s->moved[at[i]])
            settle_float(w, s, d, x, y, at[i]);
    }
    for (int32_t i = 0; s->any_moved && i < n; i++) {
        if (s->moved[i])
            settle_float(w, s, d, x, y, i);
    }
    if (!w->packed)
        ntp__gradient_pack_floats(&w->g, line, x, y, n);
}
