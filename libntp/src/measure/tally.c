/* SPDX-License-Identifier: MIT */
/*
 * tally.c - turns the cells of tallies into sums
 */
#include "texel/level.h"
#include "measure/tally.h"

#include <string.h>
#ifdef NTP_HAVE_AVX2
#  include "measure/dense_row_avx2.h"
#endif
#ifdef NTP_HAVE_AVX512
#  include "measure/colors_avx512.h"
#endif

/* Adds the cells of one row. */
static void add_row(ntp_tally *t, ntp__color_batch *batch, int32_t row, int32_t m,
                    ntp_encoding encoding)
{
    ntp__cells cells;
    const int32_t by = m / 255;
    const int32_t r = (t->cells.row[row].pair & 255) * by, g = (t->cells.row[row].pair >> 8) * by;
    const int32_t n = ntp__row_cells(&cells, &t->cells, row);
    for (int32_t done = 0, end; done < n; done = end) {
        int32_t at = batch->n;
        end = n - done < NTP__BLOCK - at ? n : done + NTP__BLOCK - at;
        for (int32_t i = done; i < end; i++, at++) {
            t->blues[cells.blue[i]] += cells.count[i];
            batch->block.c[0][at] = r;
            batch->block.c[1][at] = g;
            batch->block.c[2][at] = cells.blue[i] * by;
            batch->count[at] = cells.count[i];
        }
        batch->n = at;
        if (at == NTP__BLOCK)
            ntp__end_batch(&t->used, batch, m, encoding);
    }
}

static void add_cells(ntp_tally *t, int32_t m, ntp_encoding encoding)
{
    ntp__color_batch batch;
    bool quick = m == 255 && encoding == NTP_ENCODING_STANDARD;
    batch.n = 0;
    const bool dense = t->cells.grouped && quick; /* set with AVX2 only */
#ifdef NTP_HAVE_AVX512
    quick = quick && ntp__cpu_has_avx512(NTP__CPU_ALL);
#else
    quick = false;
#endif
    ntp__note_rows(&t->cells, ntp__steepest_of(t));
#ifdef NTP_HAVE_AVX2
    if (dense)
        ntp__note_dense_rows_avx2(&t->cells, quick ? 0 : NTP__DENSE);
#endif
    for (int32_t row = 0; (row = ntp__next_row(t->cells.at.row_seen, row)) < NTP__ROWS; row++) {
        const uint32_t seen = t->cells.at.row_seen[row];
        const bool waits =
            quick && !(seen & NTP__SEEN_OFTEN) && ntp__row_is_on_disc(&t->cells, row);
        if (!waits && !(dense && seen & NTP__SEEN_DENSE))
            add_row(t, &batch, row, m, encoding);
    }
    ntp__end_batch(&t->used, &batch, m, encoding);
#ifdef NTP_HAVE_AVX512
    if (quick)
        ntp__add_colors_avx512(&t->used, t->blues, &t->cells);
#endif
#ifdef NTP_HAVE_AVX2
    if (dense)
        ntp__add_dense_rows_avx2(&t->used, t->blues, &t->cells);
#endif
}

static void add_gray(ntp_tally *t, int32_t level, int32_t m, uint64_t count, ntp_encoding encoding)
{
    const int32_t gray[] = { level, level, level };
    if (count > 0)
        ntp__add(&t->unused, gray, (uint32_t) count, m, encoding);
}

static void take_counts(ntp__sums *sums, ntp__close_counts *close, ntp__far_counts *far)
{
    ntp__take_close(sums, close);
    ntp__merge_far(sums, far, sums);
    ntp__clear_far(far, sums);
    ntp__take_others(sums);
}

ntp_status ntp__sum_up(ntp_tally *t, ntp_encoding encoding)
{
    if (t == NULL || t->depth == 0 ||
        (encoding != NTP_ENCODING_STANDARD && encoding != NTP_ENCODING_ZZERO &&
         encoding != NTP_ENCODING_XY))
        return NTP_ERR_ARGUMENT;
    int32_t m = ntp__tally_max(t);
    bool picture = t->encoding == NTP_ENCODING_HEIGHT;
    if (!picture && m != 255 && encoding != ntp__judged_as((ntp_encoding) t->encoding))
        return NTP_ERR_FORMAT;
    if (t->summed && t->summed_encoding == (uint32_t) encoding)
        return NTP_OK;
    const ntp__sums *transparent = m == 255 ? &t->transparent_narrow : &t->transparent_wide;
    memset(t->blues, 0, sizeof t->blues); /* first: a page that is read before takes two faults */
    ntp__clear_sums(&t->used);
    ntp__clear_sums(&t->unused);
    if (!picture) {
        if (t->wide.texels > 0)
            take_counts(&t->wide, &t->close, &t->far);
        if (t->hidden)
            take_counts(&t->transparent_wide, &t->close_hidden, &t->far_hidden);
        if (t->narrow > 0) {
            ntp__merge_sums(&t->used, &t->wide);
            add_cells(t, m, encoding);
        }
        ntp__merge_sums(&t->unused, transparent);
        add_gray(t, 0, m, t->black, encoding);
        add_gray(t, m, m, t->white, encoding);
    }
    t->summed = 1;
    t->gathered = 0;
    t->summed_encoding = (uint32_t) encoding;
    return NTP_OK;
}
