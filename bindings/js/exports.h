// SPDX-License-Identifier: MIT
/*
 * exports.h - what the exported functions share: a picture as JavaScript describes it
 */
#ifndef NTP_JS_EXPORTS_H
#define NTP_JS_EXPORTS_H

#include <stdlib.h>
#include <string.h>

#include "libntp.h"

#define EXPORT(name) __attribute__((export_name(#name)))

enum { AUTO = -1 }; /* what the texels tell decides */

/* A packed picture, as JavaScript describes it. */
typedef struct picture {
    void *data;
    int32_t width, height, channels, type, encoding, y;
} picture;

static inline ntp_image view_of(const picture *p)
{
    ntp_image view =
        ntp_image_packed(p->data, p->width, p->height, p->channels, (ntp_type) p->type);

    view.encoding = (ntp_encoding) p->encoding;
    view.y = (ntp_y) p->y;
    return view;
}

static inline ntp_const_image const_view_of(const picture *p)
{
    const ntp_image view = view_of(p);

    return ntp_image_as_const(&view);
}

/* Zero-filled memory; NULL where there is none left. */
void *ntp_js_allocate(size_t size);

#endif
