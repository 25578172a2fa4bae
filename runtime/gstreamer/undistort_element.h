/// The GStreamer element raygridundistort.
#ifndef RAYGRID_GSTREAMER_UNDISTORT_ELEMENT_H
#define RAYGRID_GSTREAMER_UNDISTORT_ELEMENT_H

#include <gst/base/gstbasetransform.h>
#include <gst/gst.h>

G_BEGIN_DECLS

G_DECLARE_FINAL_TYPE(RaygridUndistort, raygrid_undistort, RAYGRID, UNDISTORT,
                     GstBaseTransform)

G_END_DECLS

#endif  // RAYGRID_GSTREAMER_UNDISTORT_ELEMENT_H
