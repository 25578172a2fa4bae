#ifndef RAYGRID_PACKING_BLOB_CAMERA_H
#define RAYGRID_PACKING_BLOB_CAMERA_H

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "camera/camera_stack.h"
#include "camera/camera_uncertainty.h"
#include "camera/sensor_mode.h"
#include "dataset/capture.h"
#include "dataset/image_files.h"
#include "dataset/row_time.h"
#include "packing/view.h"
#include "raygrid.h"
#include "rg_blob.h"

namespace raygrid {

/// A blob in memory, opened by the runtime.
class BlobCamera {
 public:
  /// Throws Error(kBlob) if the runtime refuses the bytes; name is for errors.
  BlobCamera(const std::string& name, const std::string& bytes);

  // The runtime's camera points into words_, which a move keeps in place.
  BlobCamera(BlobCamera&&) = default;
  BlobCamera& operator=(BlobCamera&&) = default;
  BlobCamera(const BlobCamera&) = delete;
  BlobCamera& operator=(const BlobCamera&) = delete;

  const rg_camera& camera() const { return camera_; }
  const rg_blob& blob() const { return blob_; }
  ImageSize image_size() const;
  bool has_remap() const { return blob_.remap != 0; }
  uint32_t NumRemaps() const;
  /// Those that undistort frames as calibrated.
  std::vector<uint32_t> TablesOfCalibratedFrames() const;

  /// The range of the stack's values, as a camera.yaml has it; nothing if the
  /// blob has no stack.
  std::optional<ConditionRange> Range() const;
  /// Goes to a value in the stack's range. Throws Error(kBlob).
  void SetCondition(double value);

  bool CanProject() const { return camera_.inverse; }

  /// The ray of a pixel by the runtime, in fixed point.
  std::optional<Eigen::Vector3d> Unproject(const Eigen::Vector2d& pixel) const;

  /// The pixel of a point by the runtime, in fixed point; of a direction, too,
  /// if the camera is central.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point) const;

  std::optional<ObservationLine> Line(const Eigen::Vector2d& pixel) const;

  /// The control points in double precision, for what the runtime does not do.
  std::unique_ptr<CameraModel> ToModel() const;

  /// The cells that the blob calls valid; nothing if it has no mask.
  std::optional<TrustMask> Trusted() const;

  /// How the camera stood while it was calibrated; nothing if the blob does not
  /// say.
  std::optional<Capture> CaptureAtCalibration() const;
  /// The time of a row; nothing if the blob does not say.
  std::optional<RowTime> TimeOfRow() const;

  /// The view of a remap table, the size of what it takes, and its direction.
  /// Throw Error(kBlob) if there is none of that number.
  VirtualView ViewOfRemap(uint32_t remap_index) const;
  ImageSize FrameSize(uint32_t remap_index) const;
  /// Whether a table makes images of the camera out of pictures of the view.
  bool Distorts(uint32_t remap_index) const;

  /// The sensor modes that tables may be of.
  std::vector<SensorMode> Modes() const;
  /// The mode of a table; nothing if it is for frames as calibrated. Throws as
  /// ViewOfRemap().
  std::optional<SensorMode> ModeOfRemap(uint32_t remap_index) const;
  /// The first table for frames of the mode of this name; nothing if there is
  /// none.
  std::optional<uint32_t> FindTableOfMode(const std::string& name) const;

  /// Undistorts an image by the runtime and one of the blob's remap tables,
  /// each channel on its own, of 8 or 16 bits; the image must have the table's
  /// FrameSize().
  Image Undistort(const Image& image, uint8_t border,
                  uint32_t remap_index = 0) const;

 private:
  Eigen::Vector2d ControlPoint(const Eigen::Vector2i& place,
                               int knots_above) const;
  // With a remap table in use; throws Error(kBlob).
  rg_camera WithTable(uint32_t remap_index) const;

  std::vector<uint32_t> words_;
  rg_camera camera_ = {};
  rg_blob blob_ = {};
};

VirtualView ViewOfTable(const rg_remap_section& table);

/// True if the file's name or first bytes are those of a blob.
bool IsBlob(const std::string& path, const std::string& bytes);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_BLOB_CAMERA_H
