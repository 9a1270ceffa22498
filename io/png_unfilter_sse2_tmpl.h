/* SPDX-License-Identifier: MIT */
/*
 * png_unfilter_sse2_tmpl.h - rows whose filters are undone with SSE2; a part of png_filter.c
 *
 * A texel waits for the one to its left, so the way from one to the next decides the speed.  Two
 * rows of Average or Paeth, one below the other, share a register: behind the upper row's texel the
 * lower row's, two texels to the left, above which the upper row is done.
 *
 * Of a texel, `most` bytes are read and written, since four are faster than three.  Those that
 * follow it are read before they are overwritten, and then written anew with their own texel.  Ends
 * of rows are read and written exactly.
 */

/* What the next texel needs of those before it.  Average: `left` with all bits turned.  Paeth:
 * numbers of 16 bits. */
typedef struct undone {
    __m128i left, above_left;
} undone;

SIZE_KNOWN size_t most_of(size_t texel)
{
    return texel == 3 ? 4 : texel == 6 ? 8 : texel;
}

/*
 * Of a, b and c the one that is nearest to a + b - c, plus `value`, modulo 256.  Let t = 3 c - a - b.
 * It is the lesser of a and b if the greater is at most t, the greater one if the lesser is at least
 * t, and c else.  If both are so, all three are equal.
 */
static inline __m128i undo_paeth16(__m128i value, __m128i a, __m128i b, __m128i c)
{
    const __m128i t = _mm_sub_epi16(_mm_sub_epi16(_mm_add_epi16(_mm_add_epi16(c, c), c), b), a);
    const __m128i least = _mm_min_epi16(a, b), greatest = _mm_max_epi16(a, b);
    const __m128i to_least =
        _mm_andnot_si128(_mm_cmpgt_epi16(greatest, t), _mm_sub_epi16(least, c));
    const __m128i to_greatest =
        _mm_andnot_si128(_mm_cmpgt_epi16(t, least), _mm_sub_epi16(greatest, c));
    const __m128i all =
        _mm_add_epi16(_mm_add_epi16(value, c), _mm_add_epi16(to_least, to_greatest));
    return _mm_and_si128(all, _mm_set1_epi16(255));
}

static inline __m128i as16(bytes value)
{
    return _mm_unpacklo_epi8(value, _mm_setzero_si128());
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
    const __m128i b16 = as16(b);
    s->left = undo_paeth16(as16(value), s->left, b16, s->above_left);
    s->above_left = b16;
    return _mm_packus_epi16(s->left, s->left);
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
    const __m128i b = _mm_unpacklo_epi64(as16(above), before);
    s->left = undo_paeth16(as16(values), s->left, b, s->above_left);
    s->above_left = b;
    return _mm_packus_epi16(s->left, s->left);
}

/* Two rows of at least four texels; `below`: the second one.  Paeth: texels of at most four bytes. */
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
    undone lower = { kind == AVERAGE ? second_of(s.left, most) : _mm_unpackhi_epi64(s.left, s.left),
                     _mm_unpackhi_epi64(s.above_left, s.above_left) };
    undo_rest(&s, next, row, above, i, size, texel, kind);
    undo_rest(&lower, next_below, below, row, i - behind, size, texel, kind);
}
