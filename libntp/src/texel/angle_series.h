/* SPDX-License-Identifier: MIT */
/*
 * angle_series.h - the numbers by which kernels find angles; angles_tmpl.h says what they are
 */
#ifndef NTP_ANGLE_SERIES_H
#define NTP_ANGLE_SERIES_H

#define MARGIN  0x1p-14 /* micro-degrees */
#define TAN_22_ 0.41421356237309503
#define C0      0x1.b521d1c1a10e6p+25
#define C1      -0x1.236be1124b1e0p+24
#define C2      0x1.5db4976e361b9p+23
#define C3      -0x1.f38f9d7edac89p+22
#define C4      0x1.84318c2d3b275p+22
#define C5      -0x1.39b58df2d6e01p+22
#define C6      0x1.e1d9d42c44f48p+21
#define C7      -0x1.fc54aa02dcb74p+20

#endif
