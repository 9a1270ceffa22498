/* SPDX-License-Identifier: MIT */
/*
 * evidence.c - gives the tests in Python access to the classifier's evidence, which is private
 */
#include "measure/evidence.h"

#if defined(__GNUC__)
__attribute__((visibility("default")))
#endif
ntp_status
ntp_test_evidence(ntp__evidence *evidence, ntp_tally *tally);

ntp_status ntp_test_evidence(ntp__evidence *evidence, ntp_tally *tally)
{
    const ntp__evidence *gathered;
    const ntp_status status = ntp__gather_evidence(&gathered, tally);
    if (status == NTP_OK)
        *evidence = *gathered;
    return status;
}
