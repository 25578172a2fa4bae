/// Formats that are made of bytes or pixels instead of a lens, one file each: a
/// row of the table in table_formats.cc.
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

// ---- What passes between a format and the commands -------------------------

/// A blob to be written, as it is.
struct BlobTable {
  std::string path;  ///< of the file; its ending may tell the kind
  std::string camera, serial;
  ImageSize image_size;
  std::string bytes;
  uint32_t crc32 = 0;    ///< that of zlib, of all bytes
  uint32_t address = 0;  ///< of the first byte, for formats that have one

  /// The runtime reads a blob that begins at a multiple of this.
  static constexpr uint32_t kAlignment = 4;
};

/// The places in a camera's image that the pixels of a view show, or the other
/// way around.
struct ViewTable {
  std::string path;
  std::string model;  ///< one of the format's
  ImageSize size, source_size;
  std::optional<Eigen::Matrix3d> matrix;  ///< K, if the view is a pinhole
  /// Row by row; NaN where a pixel has none.
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
  std::vector<double> x, y;  ///< of the columns and rows, in pixels
  /// The rays' own pixels, row by row, of a table whose columns and rows are
  /// not those of the camera; none if x and y say them.
  std::vector<Eigen::Vector2d> pixels;
  /// Unit vectors, row by row; NaN where a pixel has no ray.
  std::vector<Eigen::Vector3d> directions;
  /// Points of the rays; none if all rays begin at the origin.
  std::vector<Eigen::Vector3d> origins;
};

/// A camera to be looked up in tables, for formats that ask it themselves.
struct CameraTable {
  std::string path;
  std::string model;                      ///< one of the format's
  const CameraModel* camera = nullptr;    ///< a central one
  const ValidityMask* trusted = nullptr;  ///< none trusts all
  std::optional<double> max_error_px;     ///< that is let through
  int num_threads = 0;
};

/// The poses of boards that a camera saw.
struct PoseTable {
  std::string path;    ///< of poses.csv
  std::string output;  ///< of the file
  std::vector<BoardPose> poses;
};

/// The features of boards that cameras saw, and these boards.
struct FeatureTable {
  std::string path;    ///< of features.csv
  std::string output;  ///< of the file
  std::vector<NamedDataset> cameras;
  std::vector<Board> boards;
};

/// The files that were made, paths and contents, and a line for the user.
struct TableOutput {
  std::vector<std::pair<std::string, std::string>> files;
  std::string told;
  std::vector<std::pair<std::string, double>> metrics = {};  ///< for --json
};

// ---- The table -------------------------------------------------------------

struct TableFormat {
  std::string name;   ///< "c", for --to
  std::string holds;  ///< one line for --list
  /// That it takes, without "--"; the words of a view go without saying.
  std::vector<std::string> options;
  std::vector<std::string> models;  ///< for --model, the default first
  /// Of the files that it writes, ".npz"; none if all will do.
  std::vector<std::string> endings;

  /// The source is what is not null. Throws Error(kUsage), and Error(kQuality)
  /// if more than the largest error is left.
  TableOutput (*write_blob)(const BlobTable& blob) = nullptr;
  TableOutput (*write_view)(const ViewTable& view) = nullptr;
  TableOutput (*write_rays)(const RayTable& rays) = nullptr;
  TableOutput (*write_camera)(const CameraTable& camera) = nullptr;
  TableOutput (*write_poses)(const PoseTable& poses) = nullptr;
  TableOutput (*write_features)(const FeatureTable& features) = nullptr;
  /// A mesh of a view: exchange/mesh/mesh.h.
  const MeshUnit* mesh_unit = nullptr;

  /// Null if the format is only written. Whether bytes are of this format, and
  /// what they hold; the latter throws InputError, naming the file.
  bool (*recognizes)(const std::string& bytes) = nullptr;
  RayTable (*read_rays)(const std::string& path,
                        const std::string& bytes) = nullptr;
  /// A file does not say how large the image is that its places lie in: as
  /// large as the table unless source_size tells.
  ViewTable (*read_view)(const std::string& path, const std::string& bytes,
                         const std::optional<ImageSize>& source_size) = nullptr;
  std::vector<BoardPose> (*read_poses)(const std::string& path,
                                       const std::string& bytes) = nullptr;
  /// One camera has no name.
  FeatureTable (*read_features)(const std::string& path,
                                const std::string& bytes) = nullptr;

  bool Takes(const std::string& option) const;
  /// Whether it is made of a view, so that it takes the words of one.
  bool IsOfView() const { return write_view || mesh_unit; }
  bool IsImported() const {
    return read_rays || read_view || read_poses || read_features;
  }
  /// Text for errors where a camera is wanted: what import makes of a file.
  std::string ExplainMissingCamera() const;
  /// Throws Error(kUsage) for a file that ends otherwise.
  void RequireEnding(const std::string& path) const;
  /// "a blob", for --list and errors.
  std::string Source() const;
};

const std::vector<TableFormat>& TableFormats();

/// Null if there is none of this name.
const TableFormat* FindTableFormat(const std::string& name);
/// The format that can be read and that a file's bytes are of; null if none is.
const TableFormat* RecognizeTable(const std::string& bytes);

/// The names of all formats that are written, those of lenses first.
std::string WrittenFormatNames();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_TABLE_FORMAT_H
