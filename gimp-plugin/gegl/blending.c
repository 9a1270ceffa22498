/* SPDX-License-Identifier: MIT */
/*
 * blending.c - what GIMP does with a result, and 16-bit results that survive its blending
 */
#include "blending.h"

#include <gegl-plugin.h>

enum {
    LEVELS = 65536,
    HALVINGS = 48,  /* as fine as single precision is at the darkest levels of gamma 2.2 */
    MOST_NODES = 16 /* between a filter and where GIMP blends it */
};

typedef struct linear {
    gfloat rgba[4];
} linear;

struct blending {
    const Babl *stored; /* the layer */
    const Babl *light;  /* in the same space: RGBA, linear, single precision */
    gint channels;      /* of the layer */
    linear of_level[LEVELS];
};

/*
 * An operation is told nothing of who uses its result: only the nodes after it tell it.  Looking at
 * them changes nothing, and an unknown graph means that samples are output as they are.
 * GIMP has nodes that only pass a result on, followed by one that puts it over the layer.
 */
static ahead ahead_of(GeglNode *node, gint most_nodes)
{
    GeglNode **consumers = NULL;
    const gchar **pads = NULL;
    ahead found = AHEAD_OTHER;
    const gint count = gegl_node_has_pad(node, "output")
                           ? gegl_node_get_consumers(node, "output", &consumers, &pads)
                           : 0;
    for (gint i = 0; i < count && found == AHEAD_OTHER; i++) {
        const gchar *name = gegl_node_get_operation(consumers[i]);
        if (!g_str_equal(pads[i], "aux"))
            found = most_nodes > 0 ? ahead_of(consumers[i], most_nodes - 1) : AHEAD_OTHER;
        else if (name != NULL && g_str_has_prefix(name, "gimp:"))
            found = g_str_equal(name, "gimp:replace") &&
                            gegl_node_get_producer(consumers[i], "aux2", NULL) != NULL
                        ? AHEAD_MASK
                        : AHEAD_LAYER;
    }
    g_free(consumers);
    g_free(pads);
    return found;
}

ahead blending_ahead(GeglOperation *operation)
{
    return ahead_of(operation->node, MOST_NODES);
}

/* The smallest numbers that give a level or a higher one. */
typedef struct edge {
    gdouble rgb[3];
} edge;

static void find_edges(const blending *b, edge *edges)
{
    const Babl *fish = babl_fish(b->light, b->stored);
    linear *tried = g_new(linear, LEVELS);
    guint16 *levels = g_new(guint16, LEVELS * 4);
    gdouble step = 1;
    for (gint halving = 0; halving < HALVINGS; halving++) {
        for (gint i = 0; i < LEVELS; i++) {
            const gdouble *rgb = edges[i].rgb;
            tried[i] = (linear) { { (gfloat) (rgb[0] + step), (gfloat) (rgb[1] + step),
                                    (gfloat) (rgb[2] + step), 1 } };
        }
        babl_process(fish, tried, levels, LEVELS);
        for (gint i = 0; i < LEVELS; i++) {
            for (gint c = 0; c < 3; c++) {
                if (levels[i * b->channels + c] < i)
                    edges[i].rgb[c] += step;
            }
        }
        step /= 2;
    }
    g_free(tried);
    g_free(levels);
}

/* The middle of the numbers that become a level leaves room for the errors of blending. */
static void fill(blending *b)
{
    edge *edges = g_new0(edge, LEVELS);
    find_edges(b, edges);
    for (gint i = 0; i < LEVELS; i++) {
        const gint from = MIN(i, LEVELS - 2); /* the last level is as wide as the one before */
        for (gint c = 0; c < 3; c++) {
            const gdouble width = edges[from + 1].rgb[c] - edges[from].rgb[c];
            b->of_level[i].rgba[c] = i == 0 ? 0 : (gfloat) (edges[i].rgb[c] + width / 2);
        }
        b->of_level[i].rgba[3] = (gfloat) (i / 65535.0);
    }
    g_free(edges);
}

/*
 * The numbers depend on nothing but the format and take 0.26 s to find, so they are found once.  babl
 * keeps formats until the program ends, and a program sees few of them; each takes 1 MB here.
 */
static const blending *made_for(const pixels *stored, const Babl *light)
{
    static GMutex busy;
    static GHashTable *made;
    g_mutex_lock(&busy);
    if (made == NULL)
        made = g_hash_table_new(NULL, NULL);
    blending *b = g_hash_table_lookup(made, stored->format);
    if (b == NULL) {
        b = g_new0(blending, 1);
        b->stored = stored->format;
        b->light = light;
        b->channels = stored->channels;
        fill(b);
        g_hash_table_insert(made, (gpointer) (guintptr) b->stored, b);
    }
    g_mutex_unlock(&busy);
    return b;
}

const Babl *blending_prepare(const blending **b, const pixels *stored)
{
    const Babl *space = babl_format_get_space(stored->format);
    const BablModelFlag flags = babl_get_model_flags(babl_format_get_model(stored->format));
    if (stored->type != NTP_TYPE_U16 || stored->channels < 3 ||
        (flags & BABL_MODEL_FLAG_LINEAR) != 0 || space == babl_space("sRGB"))
        return NULL;
    if (*b == NULL || (*b)->stored != stored->format)
        *b = made_for(stored, babl_format_with_space("RGBA float", space));
    return (*b)->light;
}

void blending_put(const blending *b, gint channels, const guint16 *texels, gfloat *light,
                  gsize count)
{
    for (gsize i = 0; i < count; i++, texels += channels, light += 4) {
        for (gint c = 0; c < 3; c++)
            light[c] = b->of_level[texels[c]].rgba[c];
        light[3] = b->channels == 4 ? b->of_level[texels[3]].rgba[3] : 1;
    }
}
