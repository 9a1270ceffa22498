/* SPDX-License-Identifier: MIT */
/*
 * png_unfilter_sse2_tmpl.h - rows whose filters are undone with SSE2; a part of png_filter.c
 *
 * A texel waits for the one to its left, so the way from one to the next decides the speed.  Two or
 * four rows of Average or Paeth, one below the other, share a register: behind a row's texel that of
 * the row below, two texels to the left, above which the upper row is done.
 *
 * Of a texel, `most` bytes are read and written, since four are faster than three.  Those that
 * follow it are read before they are overwritten, and then written anew with their own texel.  Ends
 * of rows are read and written exactly.
 */

/* What the next texel needs of those before it.  Average: `left` with all bits turned. */
typedef struct undone {
    __m128i left, above_left;
} undone;

SIZE_KNOWN size_t most_of(size_t texel)
{
    return texel == 3 ? 4 : texel == 6 ? 8 : texel;
}

/*
 * Of a, b and c the one that is nearest to a + b - c, plus `value`, modulo 256.  Let `over` be how far
 * the greatest of the three is over c, and `under` how far the least is under it.  It is the least if
 * 2 over <= under, the greatest if 2 under <= over, and c else.  If both are so, all three are equal.
 * For 2 x <= y it is tested whether x <= y - x, where a negative difference counts as 0.
 */
static inline __m128i undo_paeth(__m128i value, __m128i a, __m128i b, __m128i c)
{
    const __m128i over = _mm_sub_epi8(_mm_max_epu8(a, _mm_max_epu8(b, c)), c);
    const __m128i under = _mm_sub_epi8(c, _mm_min_epu8(a, _mm_min_epu8(b, c)));
    const __m128i least = _mm_cmpeq_epi8(_mm_min_epu8(over, _mm_subs_epu8(under, over)), over);
    const __m128i greatest = _mm_cmpeq_epi8(_mm_min_epu8(under, _mm_subs_epu8(over, under)), under);
    return _mm_add_epi8(_mm_sub_epi8(_mm_add_epi8(value, c), _mm_and_si128(least, under)),
                        _mm_and_si128(greatest, over));
}

static inline undone no_texels(int kind)
{
    const __m128i zero = _mm_setzero_si128();
    return (undone) { kind == AVERAGE ? _mm_set1_epi8(-1) : zero, zero };
}

/* avg(~a, ~b) = ~floor((a + b) / 2), and ~x - v = ~(x + v): with its bits turned, a texel waits for
 * two instructions only. */
SIZE_KNOWN bytes undo_texel(undone *s, bytes value, const uint8_t *above, size_t read, int kind)
{
    if (kind == SUB) {
        s->left = _mm_add_epi8(value, s->left);
        return s->left;
    }
    const bytes b = load(above, read);
    if (kind == AVERAGE) {
        const __m128i ones = _mm_set1_epi8(-1);
        s->left = _mm_sub_epi8(_mm_avg_epu8(s->left, _mm_xor_si128(b, ones)), value);
        return _mm_xor_si128(s->left, ones);
    }
    s->left = undo_paeth(value, s->left, b, s->above_left);
    s->above_left = b;
    return s->left;
}

/* From the texel at `i` on, whose filtered bytes are `next`. */
SIZE_KNOWN void undo_rest(undone *s, bytes next, uint8_t *row, const uint8_t *above, size_t i,
                          size_t size, size_t texel, int kind)
{
    store(row + i, undo_texel(s, next, above + i, texel, kind), texel);
    for (i += texel; i < size; i += texel)
        store(row + i, undo_texel(s, load(row + i, texel), above + i, texel, kind), texel);
}

SIZE_KNOWN void undo_row(uint8_t *row, const uint8_t *above, size_t size, size_t texel, int kind)
{
    const size_t most = most_of(texel);
    undone s = no_texels(kind);
    size_t i = 0;
    bytes next = load(row, size >= most ? most : texel);
    for (; i + texel + most <= size; i += texel) {
        const bytes value = next;
        next = load(row + i + texel, most);
        store(row + i, undo_texel(&s, value, above + i, most, kind), most);
    }
    undo_rest(&s, next, row, above, i, size, texel, kind);
}

/* Two texels of at most `most` bytes in one register, and the second one of such. */
SIZE_KNOWN bytes join(bytes first, bytes second, size_t most)
{
    return most > 4 ? _mm_unpacklo_epi64(first, second) : _mm_unpacklo_epi32(first, second);
}

SIZE_KNOWN bytes second_of(bytes both, size_t most)
{
    return most > 4 ? _mm_unpackhi_epi64(both, both) : _mm_srli_epi64(both, 32);
}

/* As undo_texel, of two rows.  `before`: `left` of the upper one, two texels before. */
SIZE_KNOWN bytes undo_both(undone *s, bytes values, bytes above, __m128i before, size_t most,
                           int kind)
{
    if (kind == AVERAGE) {
        const __m128i ones = _mm_set1_epi8(-1);
        const __m128i turned = join(_mm_xor_si128(above, ones), before, most);
        s->left = _mm_sub_epi8(_mm_avg_epu8(s->left, turned), values);
        return _mm_xor_si128(s->left, ones);
    }
    const __m128i b = join(above, before, most);
    s->left = undo_paeth(values, s->left, b, s->above_left);
    s->above_left = b;
    return s->left;
}

/* Two rows of at least four texels; `below`: the second one. */
SIZE_KNOWN void undo_two_rows(uint8_t *row, uint8_t *below, const uint8_t *above, size_t size,
                              size_t texel, int kind)
{
    const size_t most = most_of(texel), behind = 2 * texel;
    undone s = no_texels(kind);
    __m128i before = s.left; /* of the upper row: the texel before the one to the left */
    bytes next = load(row, most), next_below = load(below, most);
    size_t i = 0;
    for (; i < behind; i += texel) {
        const bytes value = next;
        next = load(row + i + texel, most);
        before = s.left;
        store(row + i, undo_texel(&s, value, above + i, most, kind), most);
    }
    for (; i + texel + most <= size; i += texel) {
        const bytes values = join(next, next_below, most), over = load(above + i, most);
        next = load(row + i + texel, most);
        next_below = load(below + i + texel - behind, most);
        const __m128i left = s.left;
        const bytes both = undo_both(&s, values, over, before, most, kind);
        before = left;
        store(row + i, both, most);
        store(below + i - behind, second_of(both, most), most);
    }
    undone lower = { second_of(s.left, most), second_of(s.above_left, most) };
    undo_rest(&s, next, row, above, i, size, texel, kind);
    undo_rest(&lower, next_below, below, row, i - behind, size, texel, kind);
}

/* The texels from `from` to `end`, of a row that is done before them. */
SIZE_KNOWN void undo_part(uint8_t *row, const uint8_t *above, size_t from, size_t end, size_t texel,
                          int kind)
{
    undone s = no_texels(kind);
    if (from > 0) {
        const bytes left = load(row + from - texel, texel);
        s.left = kind == AVERAGE ? _mm_xor_si128(left, _mm_set1_epi8(-1)) : left;
        s.above_left = load(above + from - texel, texel);
    }
    for (size_t i = from; i < end; i += texel)
        store(row + i, undo_texel(&s, load(row + i, texel), above + i, texel, kind), texel);
}

enum { FOUR = 4 };

/* Of texels of at most four bytes one of each row, from the uppermost on. */
SIZE_KNOWN bytes join_four(bytes a, bytes b, bytes c, bytes d)
{
    return _mm_unpacklo_epi64(_mm_unpacklo_epi32(a, b), _mm_unpacklo_epi32(c, d));
}

SIZE_KNOWN void store_four(uint8_t *const at[FOUR], size_t i, bytes four, size_t bytes_each)
{
    store(at[0] + i, four, bytes_each);
    store(at[1] + i, _mm_srli_si128(four, 4), bytes_each);
    store(at[2] + i, _mm_srli_si128(four, 8), bytes_each);
    store(at[3] + i, _mm_srli_si128(four, 12), bytes_each);
}

SIZE_KNOWN bytes load_four(uint8_t *const at[FOUR], size_t i, size_t most)
{
    return join_four(load(at[0] + i, most), load(at[1] + i, most), load(at[2] + i, most),
                     load(at[3] + i, most));
}

/* Those to the left, `back` bytes before; in the lowest row there is none. */
SIZE_KNOWN bytes load_left(uint8_t *const at[FOUR], size_t back, size_t texel, bytes none)
{
    return join_four(load(at[0] - back, texel), load(at[1] - back, texel),
                     load(at[2] - back, texel), none);
}

/* Four rows of at least eight texels of at most four bytes; each begins `stride` after another. */
SIZE_KNOWN void undo_four_rows(uint8_t *row, ptrdiff_t stride, const uint8_t *above, size_t size,
                               size_t texel, int kind)
{
    const size_t most = most_of(texel), behind = 2 * texel, start = 3 * behind;
    const __m128i zero = _mm_setzero_si128();
    const __m128i turn = kind == AVERAGE ? _mm_set1_epi8(-1) : zero;
    const __m128i turn_first = _mm_cvtsi32_si128(kind == AVERAGE ? -1 : 0);
    uint8_t *rows[FOUR], *at[FOUR]; /* at: of each row the next texel, less i */
    const uint8_t *over[FOUR];
    for (ptrdiff_t k = 0; k < FOUR; k++) {
        rows[k] = row + k * stride;
        over[k] = k == 0 ? above : rows[k - 1];
        at[k] = rows[k] + start - (size_t) k * behind;
        undo_part(rows[k], over[k], 0, start - (size_t) k * behind, texel, kind);
    }
    undone s = { _mm_xor_si128(load_left(at, texel, texel, zero), turn), zero };
    s.above_left =
        join_four(load(above + start - texel, texel), load(at[0] - texel - behind, texel),
                  load(at[1] - texel - behind, texel), zero);
    __m128i before = _mm_xor_si128(load_left(at, behind, texel, zero), turn);
    bytes next = load_four(at, 0, most);
    size_t i = 0;
    for (; start + i + texel + most <= size; i += texel) {
        const bytes values = next;
        const bytes first = _mm_xor_si128(load(above + start + i, most), turn_first);
        const bytes b = _mm_or_si128(first, _mm_slli_si128(before, 4));
        next = load_four(at, i + texel, most);
        before = s.left;
        if (kind == AVERAGE) {
            s.left = _mm_sub_epi8(_mm_avg_epu8(s.left, b), values);
        } else {
            s.left = undo_paeth(values, s.left, b, s.above_left);
            s.above_left = b;
        }
        store_four(at, i, _mm_xor_si128(s.left, turn), most);
    }
    store_four(at, i, next, texel);
    for (size_t k = 0; k < FOUR; k++)
        undo_part(rows[k], over[k], start + i - k * behind, size, texel, kind);
}
