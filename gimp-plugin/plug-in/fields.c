/* SPDX-License-Identifier: MIT */
/*
 * fields.c - the tables of fields.h
 *
 * The names are those of the command line.  N_() marks what is shown to people.
 */
#include "fields.h"

#include <string.h>

#include "../choices.h"

#define N_(TEXT) TEXT
#define END      { NULL, NULL }

#define CHOICE_ROW(ID, NAME, LABEL) { NAME, LABEL },

/* clang-format off */

static const choice kernels[] = { /* in the order of ntp_kernel */
    NTP_KERNEL_CHOICES(CHOICE_ROW)
    END
};
static const choice borders[] = { /* ntp_border */
    NTP_BORDER_CHOICES(CHOICE_ROW)
    END
};
static const choice sources[] = { /* ntp_height_source, and two more */
    NTP_HEIGHT_SOURCE_CHOICES(CHOICE_ROW)
    { "biased", N_("Above the mean color") },
    NTP_LUMINANCE_CHOICE(CHOICE_ROW)
    END
};
static const choice green[] = { /* ntp_y */
    NTP_GREEN_CHOICES(CHOICE_ROW)
    END
};
static const choice encodings[] = { /* the first three of ntp_encoding */
    NTP_ENCODING_CHOICES(CHOICE_ROW)
    END
};
static const choice readings[] = { /* the same, found out first */
    { "auto", N_("Find out") },
    NTP_ENCODING_CHOICES(CHOICE_ROW)
    END
};
static const choice origins[] = { /* the same; last, so that the others keep their numbers */
    NTP_ENCODING_CHOICES(CHOICE_ROW)
    { "auto", N_("Find out") },
    END
};
static const choice blues[] = { /* ntp_blue */
    NTP_BLUE_CHOICES(CHOICE_ROW)
    END
};
static const choice alphas[] = { /* alpha_rule of normals.h */
    { "keep", N_("Unchanged") },
    { "one", N_("Opaque") },
    { "zero", N_("Transparent") },
    { "inverse", N_("Inverted") },
    { "height", N_("Height") },
    { "inverse-height", N_("Inverted height") },
    { "layer", N_("From another layer") },
    END
};
static const choice dudvs[] = { /* dudv_format of normals.h */
    { "none", N_("Normals") },
    { "8-signed", N_("DU/DV, 8 bits, signed") },
    { "8-unsigned", N_("DU/DV, 8 bits, unsigned") },
    { "16-signed", N_("DU/DV, 16 bits, signed") },
    { "16-unsigned", N_("DU/DV, 16 bits, unsigned") },
    END
};
static const choice channel_orders[] = { /* channel_order of channels.h */
    NTP_CHANNEL_CHOICES(CHOICE_ROW)
    END
};
static const choice dithers[] = {
    NTP_DITHER_CHOICES(CHOICE_ROW)
    END
};
static const choice presets[] = { /* preset of presets.h */
    NTP_PRESET_CHOICES(CHOICE_ROW)
    END
};
static const choice methods[] = { /* ntp_height_method */
    { "auto", N_("As the edges say") },
    { "telescoping", N_("Telescoping sums") },
    { "frankot-chellappa", N_("Frankot-Chellappa (tiles)") },
    { "poisson-dct", N_("Poisson (free edges)") },
    { "weighted", N_("Weighted, by iteration") },
    END
};
static const choice slopes[] = { /* ntp_kernel, with the one that is no stencil */
    NTP_KERNEL_CHOICES(CHOICE_ROW)
    { "baked", N_("None: a baked surface") },
    END
};
static const choice decodes[] = { /* ntp_decode */
    { "auto", N_("Find out") },
    { "unorm", N_("Exactly as stored") },
    { "neutral", N_("127 and 128 are both flat") },
    { "trunc", N_("Written by truncation") },
    { "snorm128", N_("128 is flat") },
    END
};
static const choice depths[] = { /* ntp_z, without AUTO */
    { "stored", N_("As stored") },
    { "derived", N_("From red and green") },
    END
};
static const choice results[] = {
    { "layer", N_("This layer") },
    { "image", N_("A new 16-bit gray image") },
    END
};
static const choice repairs[] = { /* ntp_clean_method; auto */
    NTP_LENGTH_CHOICES(CHOICE_ROW)
    { "auto", N_("As the errors suggest") },
    END
};
static const choice verdicts[] = { /* ntp_verdict */
    NTP_VERDICT_CHOICES(CHOICE_ROW)
    END
};

static const choice remedies[] = { /* remedy of remedy.h, after none */
    { "none", N_("None") },
    { "undo", N_("Undo an exchange or conversion, and clean") },
    { "clean", N_("Clean") },
    { "standard", N_("Make blue standard") },
    { "green", N_("Flip green") },
    END
};

static const choice scopes[] = {
    { "image", N_("The whole image") },
    { "layer", N_("This layer") },
    END
};
static const choice filters[] = { /* ntp_filter */
    { "triangle", N_("Triangle (bilinear)") },
    { "box", N_("Box (mean over the area)") },
    { "lanczos3", N_("Lanczos (sharper)") },
    END
};
static const choice edges[] = { /* the first three of ntp_border */
    { "wrap", N_("Wrap (textures that tile)") },
    { "clamp", N_("Clamp") },
    { "mirror", N_("Mirror") },
    END
};

#define NUMBER(NAME, LABEL, HELP, PAGE, VALUE, LOW, HIGH, SOFT_LOW, SOFT_HIGH, DIGITS) \
    { NAME, LABEL, HELP, FIELD_NUMBER, PAGE, VALUE, LOW, HIGH, SOFT_LOW, SOFT_HIGH, DIGITS, NULL }
#define CHOICE(NAME, LABEL, HELP, PAGE, VALUE, CHOICES) \
    { NAME, LABEL, HELP, FIELD_CHOICE, PAGE, VALUE, 0, 0, 0, 0, 0, CHOICES }
#define SWITCH(NAME, LABEL, HELP, PAGE) \
    { NAME, LABEL, HELP, FIELD_SWITCH, PAGE, 0, 0, 1, 0, 1, 0, NULL }
#define LAYER(NAME, LABEL, HELP, PAGE) \
    { NAME, LABEL, HELP, FIELD_LAYER, PAGE, -1, 0, 0, 0, 0, 0, NULL }

#define MOST 1e6 /* of a texel's sides */

static const field normals_fields[FN_COUNT] = {
    [FN_SCALE] = NUMBER("scale", NTP_SCALE_LABEL, NTP_SCALE_HELP, 0, 0, -1e9, 1e9, 0, 1000, 3),
    [FN_KERNEL] = CHOICE("kernel", NTP_KERNEL_LABEL, NTP_KERNEL_HELP, 0, 0, kernels),
    [FN_BORDER_X] = CHOICE("border-x", NTP_BORDER_X_LABEL, NTP_BORDER_X_HELP, 0, 0, borders),
    [FN_BORDER_Y] = CHOICE("border-y", NTP_BORDER_Y_LABEL, NTP_BORDER_Y_HELP, 0, 0, borders),
    [FN_SOURCE] = CHOICE("source", NTP_SOURCE_LABEL, NTP_SOURCE_HELP, 0, 0, sources),
    [FN_INVERT] = SWITCH("invert", NTP_INVERT_LABEL, NTP_INVERT_HELP, 0),
    [FN_TO_Y] = CHOICE("to-y", NTP_TO_Y_LABEL, NTP_TO_Y_HELP, 0, 0, green),
    [FN_TO] = CHOICE("to", NTP_TO_LABEL, NTP_TO_HELP, 0, 0, encodings),
    [FN_MIN_Z] = NUMBER("min-z", NTP_MIN_Z_LABEL, NTP_MIN_Z_HELP, 2, 0, 0, 1, 0, 1, 3),
    [FN_ALPHA] = CHOICE("alpha", NTP_ALPHA_LABEL,
        N_("What the alpha channel of the result holds. For another layer, first choose it under More"),
        0, 0, alphas),
    [FN_DX] = NUMBER("dx", NTP_DX_LABEL, NTP_DX_HELP, 2, 1, 1e-6, MOST, 0.1, 10, 3),
    [FN_DY] = NUMBER("dy", NTP_DY_LABEL, NTP_DY_HELP, 2, 1, 1e-6, MOST, 0.1, 10, 3),
    [FN_BLUE] = CHOICE("blue", NTP_BLUE_LABEL, NTP_BLUE_HELP, 2, 0, blues),
    [FN_HEIGHT_LAYER] = LAYER("height-layer", N_("H_eight of another layer"),
        N_("A layer of the same size that holds the height, in place of the layer itself"), 2),
    [FN_ALPHA_LAYER] = LAYER("alpha-layer", N_("Alpha fro_m another layer"),
        N_("The layer whose brightness becomes alpha; scaled to this layer's size"), 2),
    [FN_FLIP_X] = SWITCH("flip-x", N_("Flip re_d"), N_("Red points left"), 2),
    [FN_SWAP] = SWITCH("swap-rgb", N_("S_wap red and blue"), N_("Store z, y, x"), 2),
    [FN_DUDV] = CHOICE("dudv", N_("_Values to store"), N_("Normals, or x and y alone as DU/DV"),
        2, 0, dudvs),
    [FN_PRESET] = CHOICE("preset", NTP_PRESET_LABEL, NTP_PRESET_HELP, 0, 0, presets),
    [FN_STRENGTH] = NUMBER("strength", NTP_STRENGTH_LABEL, NTP_STRENGTH_HELP, 0, 1, 0, 1e6, 0, 10, 3),
    [FN_BLUR] = NUMBER("blur", NTP_BLUR_LABEL, NTP_BLUR_HELP, 1, 0, 0, 64, 0, 16, 2),
    [FN_SMALL] = NUMBER("small", NTP_SMALL_LABEL, NTP_SMALL_HELP, 1, 1, -100, 100, 0, 4, 2),
    [FN_MIDDLE] = NUMBER("middle", NTP_MIDDLE_LABEL, NTP_MIDDLE_HELP, 1, 1, -100, 100, 0, 4, 2),
    [FN_LARGE] = NUMBER("large", NTP_LARGE_LABEL, NTP_LARGE_HELP, 1, 1, -100, 100, 0, 4, 2),
    [FN_CHANNELS] = CHOICE("channels", NTP_CHANNELS_LABEL, NTP_CHANNELS_HELP, 2, 0, channel_orders),
    [FN_DITHER] = CHOICE("dither", NTP_DITHER_LABEL, NTP_DITHER_HELP, 2, 0, dithers),
    [FN_OCCLUSION] = SWITCH("occlusion", NTP_OCCLUSION_LABEL, NTP_OCCLUSION_HELP, 2),
    [FN_FORCE] = SWITCH("force", N_("Of normals too"),
        N_("Make normals also of what shows normals already; the dialog asks"), -1),
};

static const field height_fields[FH_COUNT] = {
    [FH_BORDER_X] = CHOICE("border-x", NTP_BORDER_X_LABEL,
        N_("What lies beyond the left and right edge: wrap where the texture tiles"),
        0, 3, borders),
    [FH_BORDER_Y] = CHOICE("border-y", NTP_BORDER_Y_LABEL,
        N_("What lies beyond the top and bottom edge: wrap where the texture tiles"),
        0, 3, borders),
    [FH_FROM_Y] = CHOICE("from-y", NTP_TO_Y_LABEL,
        N_("Which way green points in the layer as it is; the wrong way gives dents"),
        0, 0, green),
    [FH_FROM] = CHOICE("from", NTP_TO_LABEL,
        N_("What blue stands for in the layer as it is. \"Find out\" refuses what does not look like normals"),
        0, 3, origins),
    [FH_METHOD] = CHOICE("method", N_("_Method"), N_("How slopes become heights"), 0, 0, methods),
    [FH_KERNEL] = CHOICE("kernel", NTP_KERNEL_LABEL, N_("How the slopes were taken"), 0, 0, slopes),
    [FH_DECODE] = CHOICE("decode", N_("Le_vels"), N_("What the stored levels mean"), 0, 0, decodes),
    [FH_Z] = CHOICE("z", N_("_Z is taken"), N_("From red and green where blue is not to be trusted"),
        0, 0, depths),
    [FH_INVERT] = SWITCH("invert", NTP_INVERT_LABEL, NTP_INVERT_HELP, 0),
    [FH_CONTRAST] = NUMBER("contrast", N_("Contr_ast"),
        N_("Stretches the heights about their middle; what is then beyond black or white is cut"),
        0, 0, 0, 1, 0, 1, 2),
    [FH_RESULT] = CHOICE("result", N_("Result _in"),
        N_("8 bits are few for a height; the new image has 16"), 0, 0, results),
};

static const field check_fields[FK_COUNT] = {
    [FK_FROM] = CHOICE("from", NTP_TO_LABEL,
        N_("What blue stands for in the layer as it is"), 0, 0, readings),
    [FK_KEEP_NEGATIVE_Z] = SWITCH("keep-negative-z", NTP_KEEP_NEGATIVE_Z_LABEL,
        N_("Do not turn normals around that point into the surface"), 0),
    [FK_REMEDY] = CHOICE("remedy", N_("Remedy"),
        N_("What is then done with the layer, as by the buttons of the report"), -1, 0, remedies),
};

static const field clean_fields[FC_COUNT] = {
    [FC_METHOD] = CHOICE("method", NTP_REPAIR_LABEL, N_("How vectors get length 1"),
        0, 2, repairs), /* auto, as `ntp clean` */
    [FC_FROM] = CHOICE("from", NTP_TO_LABEL,
        N_("What blue stands for in the layer as it is"), 0, 0, readings),
    [FC_KEEP_NEGATIVE_Z] = SWITCH("keep-negative-z", NTP_KEEP_NEGATIVE_Z_LABEL,
        N_("Do not turn normals around that point into the surface"), 0),
    [FC_ONLY_FAILING] = SWITCH("only-failing", NTP_ONLY_FAILING_LABEL,
        N_("Leave texels alone that pass the test below"), 0),
    [FC_VERDICT] = CHOICE("verdict", NTP_VERDICT_LABEL, N_("How strict the test is"),
        0, 0, verdicts),
    [FC_UNUSED] = SWITCH("touch-unused", NTP_TOUCH_UNUSED_LABEL,
        N_("Treat black, white and transparent texels like any other"), 0),
    [FC_UNDO] = SWITCH("undo", N_("Put channels right _first"),
        N_("Undo first that channels were exchanged, packed as DXT5nm or converted to sRGB, or blue was inverted"), 0),
};

static const field resize_fields[FZ_COUNT] = {
    [FZ_PERCENT] = NUMBER("percent", N_("_Percent"),
        N_("The new size, in percent of the old one, where width or height is 0"),
        0, 50, 0.01, 10000, 1, 400, 2),
    [FZ_WIDTH] = NUMBER("width", N_("_Width (0: by percent)"), N_("The new width in texels; 0: by percent"),
        0, 0, 0, 65535, 0, 8192, 0),
    [FZ_HEIGHT] = NUMBER("height", N_("H_eight (0: by percent)"), N_("The new height in texels; 0: by percent"),
        0, 0, 0, 65535, 0, 8192, 0),
    [FZ_SCOPE] = CHOICE("scope", N_("_Apply to"),
        N_("The image with all its layers, which must be normals, or one layer alone"), 0, 0, scopes),
    [FZ_FILTER] = CHOICE("filter", N_("F_ilter"), N_("How normals are averaged"), 0, 0, filters),
    [FZ_BORDER_X] = CHOICE("border-x", N_("Le_ft and right edge"),
        N_("What lies beyond the left and right edge: wrap where the texture tiles"), 0, 0, edges),
    [FZ_BORDER_Y] = CHOICE("border-y", N_("_Top and bottom edge"),
        N_("What lies beyond the top and bottom edge: wrap where the texture tiles"), 0, 0, edges),
    [FZ_FROM] = CHOICE("from", N_("Range of bl_ue"),
        N_("What blue stands for in the layer as it is"), 0, 0, readings),
};

/* Plain numbers all, as the old plug-in had them. */
#define INDEX(NAME, HELP, HIGH) \
    { NAME, NAME, HELP, FIELD_NUMBER, -1, 0, 0, HIGH, 0, HIGH, 0, NULL }
static const field classic_fields[FO_COUNT] = {
    [FO_FILTER] = INDEX("filter", N_("0 4 sample, 1 Sobel 3x3, 2 Sobel 5x5, 3 Prewitt 3x3, "
        "4 Prewitt 5x5, 5 3x3, 6 5x5, 7 7x7, 8 9x9"), 8),
    [FO_MIN_Z] = NUMBER("minz", "minz", N_("Minimum z of a normal"), -1, 0, 0, 1, 0, 1, 3),
    [FO_SCALE] = NUMBER("scale", "scale", N_("Strength; its effect depends on the filter"),
        -1, 1, -1e6, 1e6, -100, 100, 3),
    [FO_WRAP] = INDEX("wrap", N_("1: the texture tiles"), 1),
    [FO_HEIGHT_SOURCE] = INDEX("height-source", N_("0 color, as the conversion says; 1 alpha"), 1),
    [FO_ALPHA] = INDEX("alpha", N_("0 unchanged, 1 height, 2 inverse height, 3 set to 0, "
        "4 set to 1, 5 invert, 6 alpha map"), 6),
    [FO_CONVERSION] = INDEX("conversion", N_("0 none, 1 biased RGB, 2 red, 3 green, 4 blue, "
        "5 maximum, 6 minimum, 7 colorspace, 8 normalize only, 9 DU/DV to normal, "
        "10 convert to height"), 10),
    [FO_DUDV] = INDEX("dudv", N_("0 none, 1 8 bits signed, 2 8 bits unsigned, 3 16 bits signed, "
        "4 16 bits unsigned"), 4),
    [FO_FLIP_X] = INDEX("xinvert", N_("1: red points left"), 1),
    [FO_FLIP_Y] = INDEX("yinvert", N_("1: green points up (OpenGL); 0: down (DirectX)"), 1),
    [FO_SWAP] = INDEX("swapRGB", N_("1: red and blue change places"), 1),
    [FO_CONTRAST] = NUMBER("contrast", "contrast", N_("Of a conversion to height"),
        -1, 0, 0, 1, 0, 1, 3),
    [FO_ALPHA_LAYER] = LAYER("alphamap", "alphamap", N_("Of alpha 6: its brightness is alpha"), -1),
};

const procedure procedures[PROCEDURE_COUNT] = {
    [PROCEDURE_NORMALS] = { "plug-in-ntp-normals-from-height",
        { N_("Normals from Another Layer"), N_("Normals from Another _Layer...") },
        { N_("Normals from Height"), N_("Normals from _Height...") },
        N_("Makes a normals texture (normal map) of the heightfield (bump map) in this or another layer, gray or color"),
        N_("White is high. Red and green are the correctly rounded values of the formula, in the "
           "layer's own precision; blue is computed from them. A gray image becomes RGB."),
        normals_fields, FN_COUNT },
    [PROCEDURE_HEIGHT] = { "plug-in-ntp-height-from-normals",
        { N_("Height from Normals"), N_("Height from _Normals...") },
        { N_("Height from Normals"), N_("Height from _Normals...") },
        N_("Makes a heightfield (bump map) of a normals texture (normal map)"),
        N_("Finds the heights whose slopes come nearest to the stored normals, and stretches "
           "them from black to white."),
        height_fields, FH_COUNT },
    [PROCEDURE_CHECK] = { "plug-in-ntp-check-normals",
        { N_("Check Normals"), N_("_Check Normals...") },
        { N_("Check Normals"), N_("_Check Normals...") },
        N_("Tells whether the layer is a normals texture, and whether it is right"),
        N_("Says what the texture is, how many texels are not unit vectors and how far they are "
           "off, and offers to clean them."),
        check_fields, FK_COUNT },
    [PROCEDURE_CLEAN] = { "plug-in-ntp-clean-normals",
        { N_("Clean Normals by Their Errors"), N_("C_lean Normals by Their Errors...") },
        { N_("Clean Normals"), N_("C_lean Normals...") },
        N_("Repairs the normals of a normals texture"),
        N_("Makes each stored normal a unit vector, as exactly as its levels can hold one. Alpha "
           "and unused texels stay."),
        clean_fields, FC_COUNT },
    [PROCEDURE_CLASSIC] = { "plug-in-normalmap", { NULL, NULL }, { NULL, NULL },
        N_("The gimp-normalmap plug-in's arguments, for scripts that call it"),
        N_("Takes the arguments of the old plug-in and computes what it meant to, correctly "
           "rounded. New scripts had better call plug-in-ntp-normals-from-height."),
        classic_fields, FO_COUNT },
    [PROCEDURE_RESIZE] = { "plug-in-ntp-resize-normals",
        { N_("Resize Normals"), N_("_Resize Normals...") },
        { N_("Resize Normals"), N_("_Resize Normals...") },
        N_("Changes the size of a normals texture (normal map), which stays one"),
        N_("Averages vectors, not colors, and makes them unit vectors again. GIMP's own scaling "
           "leaves them too short."),
        resize_fields, FZ_COUNT },
};

/* clang-format on */

const procedure *procedure_find(const char *name)
{
    for (int i = 0; i < PROCEDURE_COUNT; i++) {
        if (strcmp(procedures[i].name, name) == 0)
            return &procedures[i];
    }
    return NULL;
}

int choice_count(const field *f)
{
    int count = 0;
    while (f->choices != NULL && f->choices[count].name != NULL)
        count++;
    return count;
}

int choice_find(const field *f, const char *name)
{
    const int count = choice_count(f);
    for (int i = 0; i < count; i++) {
        if (strcmp(f->choices[i].name, name) == 0)
            return i;
    }
    return -1;
}

/* Scripts of GIMP 2.10 give arguments in order, so what is shown first may come last there. */
static bool comes_first(const field *f)
{
    return f == &normals_fields[FN_PRESET] || f == &normals_fields[FN_STRENGTH];
}

int fields_on_page(const procedure *p, int page, int fields[MAX_FIELDS])
{
    int count = 0;
    for (int first = 1; first >= 0; first--) {
        for (int i = 0; i < p->count; i++) {
            if (p->fields[i].page == page && comes_first(&p->fields[i]) == (first != 0))
                fields[count++] = i;
        }
    }
    return count;
}
