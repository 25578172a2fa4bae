#ifndef RAYGRID_PACKING_BLOB_CAMERA_H
#define RAYGRID_PACKING_BLOB_CAMERA_H

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "camera/camera_uncertainty.h"
#include "camera/operating_point_model.h"
#include "camera/sensor_mode.h"
#include "dataset/capture.h"
#include "dataset/image_files.h"
#include "dataset/line_delay.h"
#include "packing/view.h"
#include "raygrid.h"
#include "rg_blob.h"

namespace raygrid {

/// A blob in memory, opened by the runtime.
class BlobCamera {
 public:
  /// Throws Error(kInvalidBlob) if the runtime rejects the blob. name: file
  /// name in error messages.
  BlobCamera(const std::string& name, const std::string& bytes);

  // The runtime's camera points into words_, which moving does not relocate.
  BlobCamera(BlobCamera&&) = default;
  BlobCamera& operator=(BlobCamera&&) = default;
  BlobCamera(const BlobCamera&) = delete;
  BlobCamera& operator=(const BlobCamera&) = delete;

  const rg_camera& camera() const { return camera_; }
  const rg_blob& blob() const { return blob_; }
  ImageSize image_size() const;
  bool has_remap() const { return blob_.remap != 0; }
  uint32_t NumRemaps() const;
  /// Lists the remap tables for full-resolution frames, as used for
  /// calibration.
  std::vector<uint32_t> ListCalibratedTables() const;

  /// Returns the range of the operating-point model, as in camera.yaml; nullopt
  /// if the blob has none.
  std::optional<OperatingRange> Range() const;
  /// Sets the operating point within its range. Throws Error(kInvalidBlob).
  void SetOperatingPoint(double value);

  bool CanProject() const { return camera_.inverse; }

  /// Unprojects a pixel with the runtime, in fixed point.
  std::optional<Eigen::Vector3d> Unproject(const Eigen::Vector2d& pixel) const;

  /// Projects a point with the runtime, in fixed point; for central cameras
  /// also a direction.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point) const;

  std::optional<ObservationLine> Line(const Eigen::Vector2d& pixel) const;

  /// Returns a model with the control points in double precision, for functions
  /// that the runtime does not have.
  std::unique_ptr<CameraModel> ToModel() const;

  /// Returns the blob's validity mask; nullopt if it has none.
  std::optional<ValidityMask> GetValidityMask() const;

  /// Returns the capture settings at calibration; nullopt if the blob does not
  /// contain them.
  std::optional<Capture> GetCalibrationCapture() const;
  /// Returns the line delay; nullopt if the blob does not contain it.
  std::optional<LineDelay> GetRowTime() const;

  /// Returns the virtual view of a remap table. Throws Error(kInvalidBlob) if
  /// there is no table with this index; so do the next two functions.
  VirtualView GetRemapView(uint32_t remap_index) const;
  ImageSize FrameSize(uint32_t remap_index) const;
  /// Returns whether a table is an inverse remap, from the view's image to the
  /// camera's distorted image.
  bool IsInverseRemap(uint32_t remap_index) const;

  /// Returns the sensor modes of the blob, which tables can refer to.
  std::vector<SensorMode> Modes() const;
  /// Returns the sensor mode of a table; nullopt if it is for frames as
  /// calibrated. Throws like GetRemapView().
  std::optional<SensorMode> GetRemapMode(uint32_t remap_index) const;
  /// Returns the first table for frames of the mode with this name; nullopt if
  /// there is none.
  std::optional<uint32_t> FindModeTable(const std::string& name) const;

  /// Undistorts an image with the runtime and one of the blob's remap tables,
  /// channel by channel, 8 or 16 bits; the image must have the table's
  /// FrameSize().
  Image Undistort(const Image& image, uint8_t border,
                  uint32_t remap_index = 0) const;

 private:
  Eigen::Vector2d ControlPoint(const Eigen::Vector2i& place,
                               int upper_sample) const;
  // Returns the camera with a remap table selected; throws Error(kInvalidBlob).
  rg_camera WithTable(uint32_t remap_index) const;

  std::vector<uint32_t> words_;
  rg_camera camera_ = {};
  rg_blob blob_ = {};
};

VirtualView GetTableView(const rg_remap_section& table);

/// Whether the file name or first bytes identify a blob.
bool IsBlob(const std::string& path, const std::string& bytes);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_BLOB_CAMERA_H
