/* SPDX-License-Identifier: MIT */
/*
 * dither_rows_tmpl.h - a part of gradient.c: rows whose rounding errors are carried on
 */

/* The slopes of a texel: n.x / n.z and n.y / n.z, before min_z. */
static bool slopes(const walk *w, const strip *s, const facts *f, int32_t x, int32_t y, int32_t i,
                   double xy[2])
{
    if (s->moved[i] || !f->finite)
        return ntp__gradient_slopes(&w->g, x + i, y, xy);
    xy[0] = (w->ints ? (double) s->sums.i[0][i] : s->sums.d[0][i]) * w->g.cx;
    xy[1] = (w->ints ? (double) s->sums.i[1][i] : s->sums.d[1][i]) * w->g.cy;
    return true;
}

/* The slopes of a row of a wave, from column x on. */
static void row_of_slopes(walk *w, strip *s, double xy[2][NTP__WAVE_COLUMNS], int32_t x, int32_t y,
                          int32_t n)
{
    const facts f = all_tap_sums(w, s, x, y, n);
    if (w->ints && !s->any_moved) {
        for (int32_t i = 0; i < n; i++) {
            xy[0][i] = s->sums.i[0][i] * w->g.cx;
            xy[1][i] = s->sums.i[1][i] * w->g.cy;
        }
        return;
    }
    for (int32_t i = 0; i < n; i++) {
        double one[2];
        w->counts.not_finite += !slopes(w, s, &f, x, y, i, one);
        xy[0][i] = one[0];
        xy[1][i] = one[1];
    }
}

/* The slopes of half a wave from row y on, where `first` is, into its steps.  All rows of a step are
 * done at once, as their numbers lie side by side. */
static void put_slopes(walk *w, strip *s, ntp__wave_step *steps, int32_t x, int32_t y, int32_t rows,
                       int32_t first, int32_t n)
{
    enum { HALF = NTP__WAVE / 2 };
    double xy[HALF][2][NTP__WAVE_COLUMNS];
    for (int32_t k = 0; k < HALF && first + k < rows; k++) {
        row_of_slopes(w, s, xy[k], x, y + first + k, n);
        fetch_ahead(w, x, y + first + k, n);
    }
    for (int32_t t = 0; t < n + rows - 1; t++) {
        for (int32_t k = 0; k < HALF; k++) {
            const int32_t row = first + k, i = t - row;
            const bool inside = row < rows && i >= 0 && i < n;
            steps[t].slope[0][row] = inside ? xy[k][0][i] : 0;
            steps[t].slope[1][row] = inside ? xy[k][1][i] : 0;
        }
    }
}

/* Makes levels of a few rows whose rounding errors are carried on to the next texels. */
static void dither_rows(walk *w, strip *s, int32_t x, int32_t y, int32_t rows, int32_t n)
{
    const ntp__gradient *g = &w->g;
    const ntp__dithering how = { g->m, g->dst->encoding == NTP_ENCODING_ZZERO, g->min_z,
                                 g->shortened };
    ntp__wave_step steps[NTP__WAVE_STEPS];
    put_slopes(w, s, steps, x, y, rows, 0, n);
    put_slopes(w, s, steps, x, y, rows, NTP__WAVE / 2, n);
    g->loops->dither(steps, &w->along[(y - w->first) % BAND], &w->errors[x], rows, n, &how);
    for (int32_t k = 0; k < rows; k++) {
        for (int32_t i = 0; i < n; i++) {
            for (int32_t c = 0; c < 3; c++)
                s->out.c[c][i] = steps[i + k].level[c][k];
        }
        ntp__gradient_pack(g, &s->out, x, y + k, n);
    }
}
