/* SPDX-License-Identifier: MIT */
/*
 * method.c - which way of cleaning a texture's errors speak for
 */
#include "internal.h"

ntp_status ntp_choose_method(ntp_method *method, ntp_reason *why, const ntp_stats *stats,
                             ntp_encoding encoding, int32_t lossy)
{
    ntp_reason unused;
    if (why == NULL)
        why = &unused;
    if (method == NULL || stats == NULL || stats->texels == 0 ||
        (encoding != NTP_STANDARD && encoding != NTP_ZZERO && encoding != NTP_XY))
        return NTP_ERR_ARGUMENT;
    const ntp_fit *fit = encoding == NTP_ZZERO ? &stats->zzero : &stats->standard;
    uint64_t used = stats->texels - stats->unused;
    *method = NTP_DERIVE;
    *why = (ntp_reason) { NTP_REASON_Z_ALONE, 0 };
    if (encoding == NTP_XY) {
        why->code = NTP_REASON_XY_ONLY;
    } else if (fit->rounded - fit->unused_rounded == used) {
        *method = NTP_KEEP;
        why->code = NTP_REASON_ALL_ROUNDED;
    } else if (lossy) {
        *method = NTP_NORMALIZE;
        why->code = NTP_REASON_LOSSY_FILE;
    }
    return NTP_OK;
}
