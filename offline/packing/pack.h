#ifndef RAYGRID_PACKING_PACK_H
#define RAYGRID_PACKING_PACK_H

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "camera/central_generic.h"
#include "camera/equivalent_central_camera.h"
#include "camera/sensor_mode.h"
#include "dataset/camera_file.h"
#include "dataset/packing_metrics.h"
#include "packing/blob_limits.h"
#include "packing/projection_error.h"
#include "packing/view.h"
#include "rg_blob.h"

namespace raygrid {

/// A requested remap table: from full-resolution frames, or from frames of a
/// sensor mode, to a view.
struct RemapRequest {
  RemapRequest(const VirtualView& wanted_view,
               const std::optional<SensorMode>& frames_mode = std::nullopt)
      : view(wanted_view), mode(frames_mode) {}

  VirtualView view;
  std::optional<SensorMode> mode;
  /// Scene surface for a table of a non-central camera; nullopt: at infinity.
  /// Ignored for central cameras.
  std::optional<SceneSurface> scene;
  /// Whether the table is inverse: from the view's image to camera frames.
  bool distorts = false;
};

/// A central camera at sampled operating points of one variable, between which
/// devices interpolate.
struct OperatingPointSamples {
  rg_operating_parameter condition = RG_OPERATING_PARAMETER_LENS_POSITION;
  std::vector<double> values;  ///< ascending; dioptres or degrees Celsius
  /// One camera per value, with grids of equal size over one area.
  std::vector<CentralGeneric> cameras;
};

/// Chooses evenly spaced samples of a camera over a range of a condition. Uses
/// the fewest samples for which the interpolation error between neighbours, at
/// three intermediate values and over the area, is at most max_error_px. All
/// cameras have grids of equal size over one area. Throws Error(kQualityTooLow)
/// if 64 samples do not suffice.
OperatingPointSamples SelectSamples(
    rg_operating_parameter condition, double low, double high,
    const std::function<CentralGeneric(double)>& camera_at,
    double max_error_px = 0.01);

/// Samples an operating-point model of one variable.
OperatingPointSamples MakeModelSamples(const OperatingPointModel& stack);

struct PackOptions {
  std::vector<RemapRequest> remaps;  ///< one table per request
  /// Also adds a table for the default view of the camera, or a warning if the
  /// camera has none.
  bool has_default_remap = false;
  double max_error_px = 0.05;  ///< maximum geometric error of tables
  /// If even the smallest blocks exceed the limit, allows errors of up to a
  /// pixel, and reports them in a warning.
  bool is_table_bound_soft = false;
  /// Maximum unprojection error of a fitted grid if kMaxPackingErrorPx cannot
  /// be reached everywhere.
  double max_ray_error_px = kMaxPackingErrorPx;
  /// Pixels that tables show; blocks without any of these pixels become border.
  /// nullopt: all pixels.
  std::optional<ValidityMask> shown;
  /// Operating-point model in addition to the camera, which is its reference.
  /// nullopt: from the camera's file, if it has one.
  std::optional<OperatingPointSamples> stack;
  bool is_int16_allowed = true;  ///< whether 16-bit control points may be used
  int num_threads = 0;
  /// If it returns true, packing is aborted with Error(kNotConverged).
  std::function<bool()> should_stop = {};
};

/// A remap table of a blob.
struct PackedRemap {
  VirtualView view;
  std::string mode;  ///< mode of its frames; empty: as calibrated
  bool distorts = false;
  /// Maximum source error for points at infinity, if the table is for a scene.
  std::optional<double> distant_error_px;
  double error_px = 0;
  double chroma_error_px = 0;  ///< in chroma pixels
  int block_size = 0;
  int tile_size = 0;  ///< tile size of blocks with bends, otherwise block_size
};

/// A blob and the errors due to packing.
struct PackedCamera {
  std::string blob;
  /// Maximum unprojection error over the pixels of the area; in pixels over
  /// valid cells.
  double unproject_error_px = 0;
  double unproject_error_rad = 0;
  std::optional<ProjectionError> projection;  ///< nullopt: no inverse grid
  std::vector<PackedRemap> remaps;
  /// Fraction of the valid, calibrated part of the image that is invalid in the
  /// blob, because the camera model is not regular there or no grid fits it.
  double excluded_fraction = 0;
  std::vector<std::string> warnings;  ///< such as missing sections
};

PackingMetrics ComputePackingMetrics(const PackedCamera& packed);

/// Packs a camera of any model; a central one other than central-generic is
/// approximated by the coarsest grid that fits it in its regular region
/// (packing/regular_region.h). The remainder is invalid in the blob's mask and
/// border in its tables, and reported in a warning. Errors are measured with
/// the runtime's own arithmetic on the finished blob, and stored in it. A
/// central camera gets an inverse grid if possible; warnings state where it
/// does not find valid pixels. The remap of a noncentral-generic camera uses
/// its directions, which is exact for points at infinity, or the given scene.
/// Throws Error(kQualityTooLow) if the limits cannot be met anywhere or the
/// format cannot represent the camera.
PackedCamera PackCamera(const CameraFile& file, const PackOptions& options);

/// Makes a blob with a default table: of the camera's image size and the
/// resolution of the image centre, or else of the calibrated area only.
/// Warnings state why the table or the operating-point model is missing, or why
/// there is no blob; such failures, and interruptions, do not throw.
PackedCamera PackSupportedSections(
    const CameraFile& file, int num_threads,
    const std::function<bool()>& should_stop = {});

}  // namespace raygrid

#endif  // RAYGRID_PACKING_PACK_H
