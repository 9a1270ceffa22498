/* SPDX-License-Identifier: MIT */
/*
 * layouts.h - formats of texels by their numbers in DXGI and Vulkan
 */
#ifndef NTPIO_LAYOUTS_H
#define NTPIO_LAYOUTS_H

#include "texture.h"

/* Fills in what a number means: layout, name, and whether its colors are sRGB.  Returns false for
 * one that is not read; *name then says what it is, if that is known. */
bool ntpio__layout_of_dxgi(uint32_t number, ntpio__texture *t, bool *srgb);
bool ntpio__layout_of_vulkan(uint32_t number, ntpio__texture *t, bool *srgb);

#endif
