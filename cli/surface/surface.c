/* SPDX-License-Identifier: MIT */
/*
 * surface.c - what a texture says about the surface behind it: kernel, seams, steps, fit
 *
 * The fit is what the best heights leave unexplained of the normals.  A texture made from heights
 * fits up to rounding: each level is off by 0.29 (rms), and half of the square of that goes into
 * the heights.  A texture that was painted, or mixed as colors, does not fit.  A plain check uses
 * the middle of the image.  If that has holes, it uses a part without any, or a small part and
 * leaves the holes out, which takes long.
 */
#include "surface/surface.h"

#include <stdlib.h>

#include "cli.h"
#include "examine/hold_image.h"
#include "examine/middle_and_lines.h"
#include "surface/most_used_square.h"
#include "surface/solve_heights.h"

enum {
    READ_PERMILLE = 500,
    MOST_TEXELS = 16384 * 16384,     /* several files may be checked at once */
    MOST_TEXELS_HOLES = 4096 * 4096, /* holes take 49 bytes for each texel */
    HOLES_ITERATIONS = 200,
    QUICK_ITERATIONS = 80, /* of a plain check */
    SMALL = 128,           /* side of a part with holes: a plain check has no more time */
    LEAST_USED = 4         /* one texel of so many is used, else its fit means nothing */
};

/* Sides of parts without holes, the largest first. */
static const int32_t PART_SIDES[] = { 512, 256, SMALL };

/* The error of the iteration is small beside the rounding of 8 bits. */
static const double HOLES_TOLERANCE = 1e-4, QUICK_TOLERANCE = 3e-4;

/* Residuals: rounding alone with a margin; and, in levels of 8 bit, more than a border can
 * cause. */
static const double FITS = 0.25, FAR_OFF = 1;

/* Where no kernel is near, heights are best taken from baked slopes.  But whether a surface fits is
 * told by central ones, which take no account of what lies between texels. */
static const double NO_KERNEL_NEAR = 4;

static void find_nearest(ntp_kernel_fit *origin, const ntp_const_image *src, uint32_t touch)
{
    ntp_find_kernel(origin, src, touch);
    if (!origin->decided && origin->kernel == NTP_KERNEL_BAKED &&
        origin->misfit[NTP_KERNEL_BAKED] > NO_KERNEL_NEAR)
        origin->kernel = NTP_KERNEL_CENTRAL;
}

/* Sets src->y and finds the kernel.  If neither the option nor the texels nor the name say which
 * way green points, it is the way in which a kernel fits better. */
static void find_kernel(ntp_kernel_fit *origin, ntp_const_image *src, const facts *f,
                        uint32_t touch, int asked)
{
    const bool known = asked >= 0 || f->orientation.decided || f->in->y != NAME_Y_NONE;
    src->y = asked >= 0                ? (ntp_y) asked
             : f->orientation.decided  ? f->orientation.y
             : f->in->y == NAME_Y_DOWN ? NTP_Y_DOWN
                                       : NTP_Y_UP;
    find_nearest(origin, src, touch);
    if (known)
        return;
    ntp_kernel_fit other = { 0 };
    ntp_const_image flipped = *src;
    flipped.y = NTP_Y_DOWN;
    find_nearest(&other, &flipped, touch);
    if (other.points > 0 && other.misfit[other.kernel] < origin->misfit[origin->kernel]) {
        *origin = other;
        *src = flipped;
    }
}

/* What levels mean, once it is known. */
typedef struct meaning {
    ntp_decode decode;
    ntp_z z;
} meaning;

/* The rms of what the best heights leave, in levels, without the edges; negative if they cannot
 * be solved.  `border` is for an axis whose edges do not fit together.  *read becomes what was
 * found. */
static double fit_heights(source *s, const surface_facts *found, const ntp_const_image *src,
                          uint32_t touch, bool holes, ntp_border border, meaning *read)
{
    const size_t texels = (size_t) src->width * (size_t) src->height;
    const ntp_image heights =
        ntp_image_packed(buffer_reserve(&s->w->extra2, texels * sizeof(float)), src->width,
                         src->height, 1, NTP_TYPE_F32);
    const bool wraps_x = found->seam[0].wraps && src->width == s->view.width;
    const bool wraps_y = found->seam[1].wraps && src->height == s->view.height;
    const ntp_height_options how = { .method = holes ? NTP_HEIGHT_WEIGHTED : NTP_HEIGHT_AUTO,
                                     .kernel = found->origin.kernel,
                                     .border_x = wraps_x ? NTP_BORDER_WRAP : border,
                                     .border_y = wraps_y ? NTP_BORDER_WRAP : border,
                                     .decode = read->decode,
                                     .z = read->z,
                                     .touch_unused = touch,
                                     .residual_scope = NTP_RESIDUAL_INSIDE,
                                     .tolerance = found->deep ? HOLES_TOLERANCE : QUICK_TOLERANCE,
                                     .max_iterations =
                                         found->deep ? HOLES_ITERATIONS : QUICK_ITERATIONS,
                                     .dx = 1,
                                     .dy = 1 };
    const stretch part = { s->read_permille, 1000 };
    ntp_height_result done = { .residual = -1 };
    const ntp_status status = heights_solve(s->w, &heights, src, &how, part, &done);
    if (status != NTP_OK)
        return -1;
    *read = (meaning) { done.decode, done.z };
    return done.residual;
}

/*
 * The free border of the kernel central takes three times as long as one that assumes a little
 * about slopes at the edge.  So that one is tried first.  It is enough if it leaves no more than
 * rounding, or so much that the edge cannot be the cause.
 */
static double find_residual(source *s, const surface_facts *found, const ntp_const_image *src,
                            uint32_t touch, bool holes)
{
    const ntp_border free_border = ntp_free_border(found->origin.kernel);
    const double level = src->type == NTP_TYPE_U8 ? 1 : 257;
    meaning read = { NTP_DECODE_AUTO, NTP_Z_AUTO };
    double quick = -1;
    if (found->origin.kernel == NTP_KERNEL_CENTRAL && !holes)
        quick = fit_heights(s, found, src, touch, false, NTP_BORDER_EXTRAPOLATE, &read);
    if (quick >= 0 && (quick <= FITS || quick >= FAR_OFF * level))
        return quick;
    const double exact = fit_heights(s, found, src, touch, holes, free_border, &read);
    return quick >= 0 && (exact < 0 || quick < exact) ? quick : exact;
}

static ntp_const_image part_of(const ntp_const_image *src, const ntp_rect *part)
{
    ntp_const_image image = *src;
    image.data = (const unsigned char *) src->data + (ptrdiff_t) part->y0 * src->row_stride +
                 (ptrdiff_t) part->x0 * src->pixel_stride;
    image.width = part->x1 - part->x0;
    image.height = part->y1 - part->y0;
    return image;
}

/* Chooses a part of src without holes, or a small one that has more texels than holes; false: there
 * is none. */
static bool choose_part(ntp_rect *part, bool *holes, source *s, const ntp_const_image *src)
{
    const int32_t w = src->width, h = src->height;
    uint8_t *flags = buffer_reserve(&s->w->extra2, (size_t) w * (size_t) h);
    const ntp_image mask = ntp_image_packed(flags, w, h, 1, NTP_TYPE_U8);
    uint32_t used = 0;
    *part = (ntp_rect) { 0, 0, w, h };
    if (ntp_validate(&mask, src, 0, NULL) != NTP_OK)
        return false;
    for (size_t i = 0; i < (size_t) w * (size_t) h; i++)
        used += (flags[i] & NTP_FLAG_UNUSED) == 0;
    uint32_t texels = (uint32_t) w * (uint32_t) h;
    *holes = used < texels;
    if (!*holes)
        return true;
    if (texels > SMALL * SMALL) {
        for (size_t i = 0; i < sizeof PART_SIDES / sizeof *PART_SIDES; i++) {
            texels = (uint32_t) PART_SIDES[i] * (uint32_t) PART_SIDES[i];
            used = most_used_square(part, flags, w, h, PART_SIDES[i]);
            if (used == texels) {
                *holes = false;
                return true;
            }
        }
    }
    return used > 0 && used >= texels / LEAST_USED;
}

/* For a plain check of a texture with holes. */
static double find_residual_quickly(source *s, surface_facts *found, const ntp_const_image *src,
                                    uint32_t touch)
{
    ntp_rect part;
    bool holes = true;
    if (!choose_part(&part, &holes, s, src))
        return -1;
    const ntp_const_image image = part_of(src, &part);
    const int32_t x = found->area.x0, y = found->area.y0;
    found->fit_area = (ntp_rect) { x + part.x0, y + part.y0, x + part.x1, y + part.y1 };
    return find_residual(s, found, &image, touch, holes);
}

/* Fills the facts from `area` of the texture, whose texels are in `image`. */
static void look_at(source *s, facts *f, const ntp_image *image, ntp_rect area, int y, bool deep)
{
    const uint32_t touch = touch_for(&f->stats, f->encoding);
    const bool holes = f->stats.unused > 0;
    surface_facts *found = &f->surface;
    ntp_const_image src = ntp_image_as_const(image);
    src.encoding = f->encoding;
    find_kernel(&found->origin, &src, f, touch, y);
    middle_seams(s, found->seam, touch);
    if (!f->info.lossy)
        ntp_find_steps(&found->steps, &src, touch);
    found->area = found->fit_area = area;
    found->deep = deep;
    found->known = true;
    /* Slopes beside a hole were taken of heights that are not known, so holes are left out. */
    found->residual = deep || !holes ? find_residual(s, found, &src, touch, holes)
                                     : find_residual_quickly(s, found, &src, touch);
}

void surface_look(source *s, facts *f, int y)
{
    const ntp_image middle = middle_image(s);
    if (facts_are_tangent(f))
        look_at(s, f, &middle, middle_area(s), y, false);
}

/* May the whole texture and its heights be held? */
static bool whole_is_possible(const source *s, const facts *f)
{
    const uint64_t texels = (uint64_t) s->view.width * (uint64_t) s->view.height;
    return hold_is_possible(s) && texels <= (f->stats.unused > 0 ? MOST_TEXELS_HOLES : MOST_TEXELS);
}

bool surface_look_deeper(source *s, facts *f, int y, ntpio_error *error)
{
    ntp_image whole = middle_image(s);
    ntp_rect area = middle_area(s);
    void *data = NULL;
    if (!facts_are_tangent(f))
        return true;
    s->read_permille = READ_PERMILLE;
    if (!middle_is_whole(s) && whole_is_possible(s, f)) {
        area = (ntp_rect) { 0, 0, s->view.width, s->view.height };
        if (!source_rewind(s, error) || !hold_all(&whole, &data, s, error)) {
            free(data);
            return false;
        }
    }
    look_at(s, f, &whole, area, y, true);
    free(data);
    return interrupted_by == 0;
}
