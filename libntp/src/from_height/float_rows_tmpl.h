/* SPDX-License-Identifier: MIT */
/*
 * float_rows_tmpl.h - a part of gradient.c: blocks whose normals are floats
 */

/* Makes the floats of a block by the loop and fills s->doubt. */
static void encode_floats(walk *w, strip *s, const facts *f, float *const value[3], int32_t n)
{
    double sums[2][NTP__BLOCK];
    if (w->floats ? !trust_floats(w, f) : !w->doubles) {
        for (int32_t i = 0; i < n; i++)
            s->doubt[i] = 1;
        return;
    }
    sums_as_doubles(sums, w, s, NULL, n);
    for (int32_t i = n; i % NTP__LANES != 0; i++)
        sums[0][i] = sums[1][i] = 0; /* whole groups are encoded */
    w->g.loops->encode_floats(value, s->doubt, sums[0], sums[1], n, &w->encode);
}

static void do_float_block(walk *w, strip *s, int32_t x, int32_t y, int32_t n)
{
    float plane[3][NTP__BLOCK];
    float *const value[3] = { plane[0], plane[1], plane[2] };
    const facts f = all_tap_sums(w, s, x, y, n);
    encode_floats(w, s, &f, value, n);
    for (int32_t i = 0; i < n; i++) {
        if (s->doubt[i] == 0 && !s->moved[i])
            continue;
        ntp__normal normal;
        settle_exactly(w, s, &normal, x, y, i);
        for (int32_t k = 0; k < 3; k++)
            plane[k][i] = normal.value[k];
    }
    ntp__gradient_pack_floats(&w->g, value, x, y, n);
}
