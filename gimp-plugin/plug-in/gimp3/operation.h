/* SPDX-License-Identifier: MIT */
/*
 * operation.h - the operation instead of the plug-in's own work, if it makes the same texels
 */
#ifndef NTP_PLUGIN_OPERATION_H
#define NTP_PLUGIN_OPERATION_H

#include "host.h"

/*
 * Lets GIMP merge ntp:normals-from-height into the layer, in one undo step.  FALSE: nothing was
 * done, and the plug-in has to make the normals.
 */
gboolean operation_merge(const settings *s, const host_layer *layer);

#endif
