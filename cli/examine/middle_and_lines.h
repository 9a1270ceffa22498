/* SPDX-License-Identifier: MIT */
/*
 * middle_and_lines.h - what a check keeps of the rows that go by: the middle, and some lines
 */
#ifndef NTP_CLI_MIDDLE_AND_LINES_H
#define NTP_CLI_MIDDLE_AND_LINES_H

#include "examine/examine.h"

/* Where in the image the middle is: at most 1024 x 1024 texels. */
ntp_rect middle_area(const source *s);
bool middle_is_whole(const source *s);

/* Call before the first row, and for each block of rows.  Both do nothing unless s->keep_middle. */
void middle_begin(source *s);
void middle_rows(source *s, const ntp_rect *area);

/* After the last row: the middle, seen as the view is now. */
ntp_image middle_image(const source *s);

/* Do the edges of the image fit together?  Across, and down. */
ntp_status middle_seams(const source *s, ntp_seam seam[2], uint32_t touch);

#endif
