/* SPDX-License-Identifier: MIT */
/*
 * packed_tmpl.h - conversions of packed samples, a chunk at a time; a part of convert_packed.c, which
 * includes it for each SAMPLE type
 *
 * What happens to a sample depends on its channel alone, so a chunk of whole texels is treated as
 * samples with a pattern of factors.  Only unused texels differ.  A chunk can have some where a red
 * sample is 0 or M, or an alpha 0; then its texels are looked at one by one.
 */

/* The unused texels of a chunk, as bits. */
static uint64_t FOR_SAMPLE(unused)(const SAMPLE *s, int32_t samples, const ntp__conversion *j)
{
    uint64_t found = 0;
    const int32_t channels = j->src->channels, m = j->ms;
    for (int32_t i = 0; i * channels < samples; i++, s += channels) {
        int32_t b = channels > 2 ? s[2] : (s[0] | s[1]) != 0 ? m : 0, a = channels > 3 ? s[3] : m;
        found |= (uint64_t) ntp__unused(s[0], s[1], b, a, m, j->how.touch_unused) << i;
    }
    return found;
}

static inline SAMPLE FOR_SAMPLE(suspect)(const SAMPLE *s, const SAMPLE *if_none,
                                         const SAMPLE *if_all)
{
    SAMPLE odd = 0;
    for (int32_t i = 0; i < CHUNK; i++)
        odd |= (SAMPLE) ((-(s[i] == 0) & if_none[i]) | (-(s[i] == (SAMPLE) -1) & if_all[i]));
    return odd;
}

static inline void FOR_SAMPLE(watch)(SAMPLE *if_none, SAMPLE *if_all, int32_t channels, bool flip)
{
    for (int32_t i = 0; i < CHUNK; i++) {
        if_none[i] = (SAMPLE) (flip && i % channels % 3 == 0 ? -1 : 0);
        if_all[i] = (SAMPLE) (flip && i % channels == 0 ? -1 : 0);
    }
}

/* Copies texels of the same format; used ones are flipped if that is asked for. */
static void FOR_SAMPLE(move_some)(const ntp__conversion *j, int32_t x, int32_t y, int32_t n)
{
    const int32_t channels = j->src->channels, samples = n * channels;
    const SAMPLE *s = (const SAMPLE *) ntp__at(j->src, x, y);
    SAMPLE *d = (SAMPLE *) ntp__at_mut(j->dst, x, y);
    SAMPLE flips[CHUNK], if_none[CHUNK], if_all[CHUNK], in[CHUNK], out[CHUNK];
    FOR_SAMPLE(watch)(if_none, if_all, channels, j->flip);
    for (int32_t i = 0; i < CHUNK; i++)
        flips[i] = (SAMPLE) (j->flip && i % channels == 1 ? -1 : 0);
    memset(in, 1, sizeof in);
    for (int32_t at = 0; at < samples; at += CHUNK, s += CHUNK, d += CHUNK) {
        const bool whole = samples - at >= CHUNK;
        const size_t size = (size_t) (samples - at) * sizeof *s;
        memcpy(in, s, whole ? sizeof in : size);
        for (int32_t i = 0; i < CHUNK; i++)
            out[i] = in[i] ^ flips[i];
        if (FOR_SAMPLE(suspect)(in, if_none, if_all)) {
            uint64_t unused = FOR_SAMPLE(unused)(in, whole ? CHUNK : samples - at, j);
            for (int32_t i = 1; unused != 0; unused >>= 1, i += channels) {
                if (unused & 1)
                    out[i] = in[i];
            }
        }
        memcpy(d, out, whole ? sizeof out : size);
    }
}

void FOR_SAMPLE(ntp__move)(const ntp__conversion *j, int32_t x, int32_t y, int32_t n,
                           ntp_convert_counts *counts)
{
    (void) counts;
#ifdef NTP_HAVE_AVX2
    if (j->flip && j->src->channels == 3 && ntp__cpu_has_avx2(NTP__CPU_ALL)) {
        const uint32_t touch = j->how.touch_unused;
        ntp__flip_rgb_avx2(ntp__at_mut(j->dst, x, y), ntp__at(j->src, x, y), n, sizeof(SAMPLE) == 2,
                           !(touch & NTP_UNUSED_BLACK), !(touch & NTP_UNUSED_WHITE));
        return;
    }
#endif
    FOR_SAMPLE(move_some)(j, x, y, n);
}
