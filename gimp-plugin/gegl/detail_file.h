/* SPDX-License-Identifier: MIT */
/*
 * detail_file.h - the details for ntp:blend-normals-file, from a picture file
 */
#ifndef NTP_GEGL_DETAIL_FILE_H
#define NTP_GEGL_DETAIL_FILE_H

#include <gegl-plugin.h>

/* What was read last; zero: nothing.  Free it by looking for the path NULL. */
typedef struct detail_file {
    gchar *path;
    gint64 changed, size; /* of the file */
    GeglBuffer *picture;  /* NULL: there is no such picture */
} detail_file;

/* Reads the file unless that was done and it has not changed.  To be called by prepare(). */
void detail_file_look(detail_file *file, const gchar *path);

/*
 * Where the input's 0, 0 is in the layer, in x and y.  GIMP moves a selected part there.
 */
void detail_file_place(GeglOperation *operation, gint place[2]);

#endif
