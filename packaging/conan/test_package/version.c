/* SPDX-License-Identifier: MIT */
/* Cleans one texel, and says with which version. */
#include <libntp.h>

#include <stdio.h>

int main(void)
{
    unsigned char texel[3] = { 200, 100, 10 };
    ntp_image image = ntp_image_packed(texel, 1, 1, 3, NTP_TYPE_U8);
    ntp_const_image source = ntp_image_as_const(&image);
    ntp_status status = ntp_clean(&image, &source, NULL, NULL, NULL, NULL);
    printf("libntp %d.%d.%d: %d %d %d\n", NTP_VERSION_MAJOR, NTP_VERSION_MINOR, NTP_VERSION_PATCH,
           texel[0], texel[1], texel[2]);
    return status != NTP_OK || texel[0] != 200 || texel[1] != 100 || texel[2] != 229;
}
