/* SPDX-License-Identifier: MIT */
/*
 * detail_file.c - the details for ntp:blend-normals-file, from a picture file
 */
#include "detail_file.h"

#include "blending.h"

#include <glib/gstdio.h>

enum { MOST_NODES = 2 }; /* between the input and the node that moves the selected part */

static GeglBuffer *read_picture(const gchar *path)
{
    GeglBuffer *picture = NULL;
    GeglNode *graph = gegl_node_new();
    GeglNode *load = gegl_node_new_child(graph, "operation", "gegl:load", "path", path, NULL);
    GeglNode *sink =
        gegl_node_new_child(graph, "operation", "gegl:buffer-sink", "buffer", &picture, NULL);
    gegl_node_link(load, sink);
    gegl_node_process(sink);
    g_object_unref(graph);
    return picture;
}

void detail_file_look(detail_file *file, const gchar *path)
{
    GStatBuf about = { 0 };
    if (path == NULL || *path == '\0' || g_stat(path, &about) != 0 ||
        !g_file_test(path, G_FILE_TEST_IS_REGULAR))
        path = NULL;
    if (g_strcmp0(path, file->path) == 0 && file->changed == (gint64) about.st_mtime &&
        file->size == (gint64) about.st_size)
        return;
    g_clear_object(&file->picture);
    g_free(file->path);
    *file = (detail_file) { .path = g_strdup(path),
                            .changed = path == NULL ? 0 : (gint64) about.st_mtime,
                            .size = path == NULL ? 0 : (gint64) about.st_size,
                            .picture = path == NULL ? NULL : read_picture(path) };
}

void detail_file_place(GeglOperation *operation, gint place[2])
{
    GeglNode *node = operation->node;
    place[0] = place[1] = 0;
    if (blending_ahead(operation) == AHEAD_OTHER)
        return;
    for (gint i = 0; i < MOST_NODES && node != NULL; i++) {
        node = gegl_node_get_producer(node, "input", NULL);
        if (node == NULL || g_strcmp0(gegl_node_get_operation(node), "gegl:translate") != 0)
            continue;
        gdouble x = 0, y = 0;
        gegl_node_get(node, "x", &x, "y", &y, NULL);
        place[0] = (gint) -x;
        place[1] = (gint) -y;
        break;
    }
}
