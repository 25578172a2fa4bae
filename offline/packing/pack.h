#ifndef RAYGRID_PACKING_PACK_H
#define RAYGRID_PACKING_PACK_H

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "camera/camera_of_scene.h"
#include "camera/central_generic.h"
#include "camera/sensor_mode.h"
#include "dataset/camera_file.h"
#include "packing/blob_limits.h"
#include "packing/projection_error.h"
#include "packing/view.h"
#include "rg_blob.h"

namespace raygrid {

/// A table that is asked for: of a view, from frames as calibrated or of a
/// mode.
struct RemapRequest {
  RemapRequest(const VirtualView& wanted_view,
               const std::optional<SensorMode>& frames_mode = std::nullopt)
      : view(wanted_view), mode(frames_mode) {}

  VirtualView view;
  std::optional<SensorMode> mode;
  /// The surface of the scenes that a table of a camera of lines is for;
  /// nothing: far away. Central cameras do not ask.
  std::optional<SceneSurface> scene;
  /// The other direction: the view's pictures become frames of the camera.
  bool distorts = false;
};

/// A central camera at several values of a condition, between which boards
/// blend it.
struct StackKnots {
  rg_condition condition = RG_CONDITION_LENS_POSITION;
  std::vector<double> values;  ///< ascending; dioptres, or degrees Celsius
  /// One camera a value, with grids of one size over one area.
  std::vector<CentralGeneric> cameras;
};

/// Chooses knots for a camera over a range of a condition: evenly spaced ones,
/// as few as keep the blend between any two within a bound of the camera, in
/// pixels over its area, at three values between them. All cameras have grids
/// of one size over one area. Throws Error(kQuality) if 64 knots do not keep
/// the bound.
StackKnots ChooseKnots(rg_condition condition, double low, double high,
                       const std::function<CentralGeneric(double)>& camera_at,
                       double max_error_px = 0.01);

/// The knots of a stack over one condition that was calibrated.
StackKnots KnotsOf(const CameraStack& stack);

struct PackOptions {
  std::vector<RemapRequest> remaps;  ///< one table each
  /// One more of the view that the camera can give; a remark if it has none.
  bool has_default_remap = false;
  double max_error_px = 0.05;  ///< their geometric error
  /// Where small blocks do not keep that, tables may be off by as much as a
  /// pixel; a remark then says by how much.
  bool is_table_bound_soft = false;
  /// The error of un-projection that a fitted grid may have: at most
  /// kMaxPackingErrorPx where that can be had everywhere, and this elsewhere.
  double max_ray_error_px = kMaxPackingErrorPx;
  /// The pixels that tables show: blocks in which none is are border. Without,
  /// all are shown.
  std::optional<TrustMask> shown;
  /// A stack beside the camera, which is the one at a reference. Without, that
  /// of the camera's file, if it has one.
  std::optional<StackKnots> stack;
  bool is_narrow_allowed = true;  ///< control points of 16 bits
  int num_threads = 0;
  /// Once true, packing ends by Error(kNotConverged).
  std::function<bool()> should_stop = {};
};

/// A remap table of a blob.
struct PackedRemap {
  VirtualView view;
  std::string mode;  ///< of its frames; empty: as calibrated
  bool distorts = false;
  /// How far off sources are of what is far away, at most, where the table is
  /// for a scene.
  std::optional<double> far_error_px;
  double error_px = 0;
  double chroma_error_px = 0;  ///< in chroma's own pixels
  int block_size = 0;
  int part_size = 0;  ///< of bent blocks; otherwise as block_size
};

/// A blob and the errors that packing added.
struct PackedCamera {
  std::string blob;
  /// The errors of un-projection over the pixels of the area; in pixels, those
  /// of trusted cells.
  double unproject_error_px = 0;
  double unproject_error_rad = 0;
  std::optional<ProjectionError> projection;  ///< none: cannot project
  std::vector<PackedRemap> remaps;
  /// The part of the image, of what is calibrated and trusted, that the blob
  /// calls invalid: there the camera is not regular, or no grid follows it.
  double left_out_part = 0;
  std::vector<std::string> remarks;  ///< on what it lacks
};

/// Packs a camera of any model; a central one that is not central-generic is
/// fitted with the coarsest grid that follows it in its regular region
/// (packing/regular_region.h). What is left out is invalid in the blob's mask,
/// the region's outside is border in its tables, and a remark says how much.
/// The errors are measured with the runtime's own arithmetic on the finished
/// blob, and stored in it. A central camera gets an inverse grid if one can be
/// had; remarks say where it does not lead back to trusted pixels. The remap of
/// a noncentral-generic camera is that of its directions, right for far scenes,
/// or that for the distance.
/// Throws Error(kQuality) if the bounds cannot be kept anywhere or the format
/// cannot hold the camera.
PackedCamera PackCamera(const CameraFile& file, const PackOptions& options);

/// Throws Error(kUsage) for a name or a serial number that no blob can hold;
/// what says which.
void RequireBlobText(const char* what, const std::string& text);

/// A blob with a table as large as the camera's images: as sharp as they are in
/// the middle, or else of the calibrated area alone. Remarks say why it lacks
/// the table or the stack, or why there are no bytes at all; nothing is thrown
/// for that, nor if it is told to stop.
PackedCamera PackWhatCanBe(const CameraFile& file, int num_threads,
                           const std::function<bool()>& should_stop = {});

}  // namespace raygrid

#endif  // RAYGRID_PACKING_PACK_H
