/* SPDX-License-Identifier: MIT */
/*
 * operation.h - the operation in place of the plug-in's own work, where it makes the same texels
 */
#ifndef NTP_PLUGIN_OPERATION_H
#define NTP_PLUGIN_OPERATION_H

#include "host.h"

/*
 * Lets GIMP merge ntp:normals-from-height into the layer, in one undo step.  FALSE: nothing was
 * done, the plug-in has to make the normals.
 */
gboolean operation_merge(const settings *s, const host_layer *layer);

#endif
