/* SPDX-License-Identifier: MIT */
/*
 * refusal.c - which files are refused: those without normals in tangent space
 */
#include "write/refusal.h"

bool is_unordered_pair(const facts *f)
{
    return f->type.type == NTP_CLASS_XY && f->info.channels < 3 && !f->forced;
}

bool has_tangent_normals(const facts *f, bool any_order)
{
    const ntp_class type = f->type.type;
    if (f->forced)
        return f->encoding != NTP_ENCODING_HEIGHT;
    return type != NTP_CLASS_HEIGHT && type != NTP_CLASS_OBJECT_SPACE &&
           type != NTP_CLASS_NOT_NORMALS && (any_order || !is_unordered_pair(f));
}

void add_refusal(text *t, const facts *f, const char *option)
{
    const bool pair = is_unordered_pair(f);
    if (pair)
        text_add(t, "gray and alpha are x and y, but the file does not say which is which");
    else
        text_addf(t, "%s, not a texture of tangent-space normals",
                  f->type.type == NTP_CLASS_HEIGHT         ? "a height map"
                  : f->type.type == NTP_CLASS_OBJECT_SPACE ? "object-space normals"
                                                           : "something else");
    const bool height = f->type.type == NTP_CLASS_HEIGHT;
    if (height)
        text_add(t,
                 "; ntp from-height --scale 10 makes normals of it, as a surface 10 texels high");
    if (option != NULL && (!height || f->info.channels >= 3))
        text_addf(t, pair ? "; --%s xy takes gray for x" : "; --%s standard takes it for one",
                  option);
}
