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
static void row_of_slopes(walk *w, strip *s, double *const xy[2], int32_t x, int32_t y, int32_t n)
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

/* The slopes of rows from y on into the steps of a wave. */
static void put_slopes(walk *w, strip *s, ntp__wave_step *steps, int32_t x, int32_t y, int32_t rows,
                       int32_t n)
{
    ntp__wave_rows *part = &w->wave->part;
    memset(part, 0, sizeof *part);
    for (int32_t first = 0; first < NTP__WAVE; first += NTP__WAVE_PART) {
        for (int32_t k = 0; k < NTP__WAVE_PART; k++) {
            double(*const slope)[NTP__WAVE_ROOM] = part->slope[k];
            double *const to[2] = { slope[0] + NTP__WAVE, slope[1] + NTP__WAVE };
            if (first + k >= rows) {
                memset(slope, 0, sizeof part->slope[k]);
                continue;
            }
            row_of_slopes(w, s, to, x, y + first + k, n);
            fetch_ahead(w, x, y + first + k, n);
        }
        w->g.loops->put_slopes(steps, part, first, n + rows - 1);
    }
}

/* Packs the levels of rows from y on. */
static void take_levels(walk *w, strip *s, const ntp__wave_step *steps, int32_t x, int32_t y,
                        int32_t rows, int32_t n)
{
    ntp__wave_rows *part = &w->wave->part;
    for (int32_t k = 0; k < rows; k++) {
        const int32_t row = k % NTP__WAVE_PART;
        if (row == 0)
            w->g.loops->take_levels(part, steps, k, n + rows - 1);
        for (int32_t c = 0; c < 3; c++) {
            for (int32_t i = 0; i < n; i++)
                s->out.c[c][i] = part->level[row][c][NTP__WAVE + i];
        }
        ntp__gradient_pack(&w->g, &s->out, x, y + k, n);
    }
}

/* Makes levels of a few rows whose rounding errors are carried on to the next texels. */
static void dither_rows(walk *w, strip *s, int32_t x, int32_t y, int32_t rows, int32_t n)
{
    const ntp__gradient *g = &w->g;
    const ntp__dithering how = { g->m, g->dst->encoding == NTP_ENCODING_ZZERO, g->min_z,
                                 g->shortened };
    ntp__wave_step *steps[NTP__WAVES];
    double *along = &w->along[(y - w->first) % BAND], *down = &w->errors[x];
    for (int32_t k = 0; k < NTP__WAVES; k++) {
        const int32_t left = rows - k * NTP__WAVE;
        steps[k] = w->wave->steps[k];
        if (left > 0)
            put_slopes(w, s, steps[k], x, y + k * NTP__WAVE, left < NTP__WAVE ? left : NTP__WAVE,
                       n);
    }
    if (w->waves != NULL)
        w->waves(steps, along, down, rows, n, how.zzero);
    else
        g->loops->dither(steps[0], along, down, rows, n, &how);
    for (int32_t k = 0; k * NTP__WAVE < rows; k++) {
        const int32_t left = rows - k * NTP__WAVE;
        take_levels(w, s, steps[k], x, y + k * NTP__WAVE, left < NTP__WAVE ? left : NTP__WAVE, n);
    }
}
