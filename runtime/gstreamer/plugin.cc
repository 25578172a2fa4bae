#include <gst/gst.h>

#include "undistort_element.h"

namespace {

gboolean Initialize(GstPlugin* plugin) {
  return gst_element_register(plugin, "raygridundistort", GST_RANK_NONE,
                              raygrid_undistort_get_type());
}

}  // namespace

#define PACKAGE "raygrid"
GST_PLUGIN_DEFINE(GST_VERSION_MAJOR, GST_VERSION_MINOR, raygrid,
                  "Undistortion with raygrid blobs", Initialize,
                  RAYGRID_VERSION, "MIT/X11", "raygrid", "raygrid")
