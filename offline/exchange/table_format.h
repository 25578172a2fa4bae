/// Formats made from blobs, tables or pixels instead of camera models, one file
/// each, listed in table_formats.cc.
#ifndef RAYGRID_EXCHANGE_TABLE_FORMAT_H
#define RAYGRID_EXCHANGE_TABLE_FORMAT_H

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "camera/camera_model.h"
#include "camera/camera_uncertainty.h"
#include "dataset/dataset.h"
#include "exchange/mesh/mesh.h"

namespace raygrid {

// ---- Data exchanged between formats and commands ---------------------------

/// A blob to export, unchanged.
struct BlobTable {
  std::string path;  ///< output file; its extension may select the kind
  std::string camera, serial;
  ImageSize image_size;
  std::string bytes;
  uint32_t crc32 = 0;    ///< CRC of zlib over all bytes
  uint32_t address = 0;  ///< address of the first byte, if the format has one

  /// Alignment in bytes of a blob, required by the runtime.
  static constexpr uint32_t kAlignment = 4;
};

/// Positions in a camera's image for each pixel of a view, or vice versa.
struct ViewTable {
  std::string path;
  std::string model;  ///< one of the format's models
  ImageSize size, source_size;
  std::optional<Eigen::Matrix3d> matrix;  ///< K of a pinhole view
  /// Row by row; NaN for pixels without a source.
  std::vector<Eigen::Vector2d> sources;

  size_t num_pixels() const {
    return static_cast<size_t>(size.width) * size.height;
  }
  std::optional<Eigen::Vector2d> At(int x, int y) const;
};

/// The rays of a camera's pixels, in camera axes and metres.
struct RayTable {
  std::string path;
  ImageSize image_size;
  std::vector<double> x, y;  ///< pixel coordinates of columns and rows
  /// The rays' pixels, row by row, if columns and rows are not the camera's;
  /// empty if x and y define them.
  std::vector<Eigen::Vector2d> pixels;
  /// Unit vectors, row by row; NaN for pixels without a ray.
  std::vector<Eigen::Vector3d> directions;
  /// Points on the rays; empty if all rays start at the origin.
  std::vector<Eigen::Vector3d> origins;
};

/// A camera, for formats whose export samples it.
struct ExportedCamera {
  std::string path;
  std::string model;                    ///< one of the format's models
  const CameraModel* camera = nullptr;  ///< central camera
  const ValidityMask* valid_region =
      nullptr;                         ///< valid region; null: all pixels
  std::optional<double> max_error_px;  ///< maximum accepted error
  int num_threads = 0;
};

/// Board poses observed by a camera.
struct PoseTable {
  std::string path;    ///< path of poses.csv
  std::string output;  ///< output file
  std::vector<BoardPose> poses;
};

/// Board features observed by cameras, and the boards.
struct FeatureTable {
  std::string path;    ///< path of features.csv
  std::string output;  ///< output file
  std::vector<NamedDataset> cameras;
  std::vector<Board> boards;
};

/// Output files (path, contents), and a line for the user.
struct TableOutput {
  std::vector<std::pair<std::string, std::string>> files;
  std::string configuration;
  std::vector<std::pair<std::string, double>> metrics = {};  ///< for --json
};

// ---- The table -------------------------------------------------------------

struct TableFormat {
  std::string name;   ///< "c", for --to
  std::string holds;  ///< one line for --list
  /// Accepted options, without "--"; options of views are implied.
  std::vector<std::string> options;
  std::vector<std::string> models;  ///< for --model, the default first
  /// Allowed extensions of output files, ".npz"; empty: any.
  std::vector<std::string> endings;

  /// The non-null function determines the source. Throws Error(kUsage), and
  /// Error(kQualityTooLow) if the maximum error is exceeded.
  TableOutput (*write_blob)(const BlobTable& blob) = nullptr;
  TableOutput (*write_view)(const ViewTable& view) = nullptr;
  TableOutput (*write_rays)(const RayTable& rays) = nullptr;
  TableOutput (*write_camera)(const ExportedCamera& camera) = nullptr;
  TableOutput (*write_poses)(const PoseTable& poses) = nullptr;
  TableOutput (*write_features)(const FeatureTable& features) = nullptr;
  /// Mesh of a view: see exchange/mesh/mesh.h.
  const MeshUnit* mesh_unit = nullptr;

  /// Null if the format is write-only. Recognizes and reads bytes; readers
  /// throw InputError with the file's name.
  bool (*recognizes)(const std::string& bytes) = nullptr;
  RayTable (*read_rays)(const std::string& path,
                        const std::string& bytes) = nullptr;
  /// Reads a view. Files do not contain the size of the image that the
  /// positions refer to: it is source_size, or by default the size of the
  /// table.
  ViewTable (*read_view)(const std::string& path, const std::string& bytes,
                         const std::optional<ImageSize>& source_size) = nullptr;
  std::vector<BoardPose> (*read_poses)(const std::string& path,
                                       const std::string& bytes) = nullptr;
  /// Reads features. The name of a single camera is empty.
  FeatureTable (*read_features)(const std::string& path,
                                const std::string& bytes) = nullptr;

  bool AcceptsOption(const std::string& option) const;
  /// Returns whether files contain a view, so that the options of views are
  /// accepted.
  bool IsOfView() const { return write_view || mesh_unit; }
  bool IsImported() const {
    return read_rays || read_view || read_poses || read_features;
  }
  /// Returns the error text for a file of this format that is passed instead of
  /// a camera.
  std::string ExplainMissingCamera() const;
  /// Throws Error(kUsage) for a path with another extension.
  void RequireEnding(const std::string& path) const;
  /// Returns the source, such as "a blob", for --list and errors.
  std::string Source() const;
};

const std::vector<TableFormat>& TableFormats();

/// Returns null if there is no format with this name.
const TableFormat* FindTableFormat(const std::string& name);
/// Returns the readable format of a file's bytes; null if not recognized.
const TableFormat* RecognizeTable(const std::string& bytes);

/// Returns the names of all writable formats, camera formats first.
std::string WrittenFormatNames();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_TABLE_FORMAT_H
