/// Warp meshes for hardware dewarping engines: source positions at the vertices
/// of a grid over the output image, in the number format of the engine, which
/// interpolates between them.
#ifndef RAYGRID_EXCHANGE_MESH_MESH_H
#define RAYGRID_EXCHANGE_MESH_MESH_H

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "camera/area.h"
#include "exchange/pixel_origin.h"

namespace raygrid {

/// Output pixels at which a mesh has vertices. The last column and row may lie
/// outside the output image.
struct MeshLattice {
  std::vector<int> x, y;

  int columns() const { return static_cast<int>(x.size()); }
  int rows() const { return static_cast<int>(y.size()); }
  size_t num_vertices() const { return x.size() * y.size(); }
};

/// Cell index and fraction of an output coordinate along one axis of the mesh.
struct MeshStep {
  int vertex = 0;
  double part = 0;  ///< between vertices `vertex` and `vertex` + 1
};
/// Returns the steps of the output coordinates 0 to count - 1.
std::vector<MeshStep> LocatePixelsOnAxis(const std::vector<int>& vertices,
                                         int count);

/// Interpolation of an engine between the vertices along one axis.
enum class MeshInterpolation {
  kLine,    ///< piecewise linear
  kPatch,   ///< piecewise quadratic, three vertices per segment, without
            ///< overlap
  kNearest  ///< quadratic through the nearest vertex and its two neighbours
};
/// Returns "lines", "patches" or "nearest".
std::string GetInterpolationName(MeshInterpolation interpolation);

/// Index of the first of three consecutive vertices, and their weights.
struct MeshWeights {
  int vertex = 0;
  std::array<double, 3> weights = {0, 0, 0};
};
/// Returns the interpolation weights of the output coordinates 0 to count - 1.
/// Quadratic interpolation assumes evenly spaced vertices.
std::vector<MeshWeights> ComputeWeightsOnAxis(const std::vector<int>& vertices,
                                              int count,
                                              MeshInterpolation interpolation);

/// Sizes of the output image and of the camera's image, in pixels.
struct MeshRequest {
  ImageSize size, source_size;
  std::optional<int> step;  ///< vertex spacing in pixels (--stride)
};

/// A mesh before quantization to the number format of an engine. Positions are
/// in raygrid's pixel coordinates.
struct MeshTable {
  std::string path;
  ImageSize size, source_size;
  MeshLattice lattice;
  /// Source positions of the vertices, row-major, all finite. Vertices with
  /// is_needed come from the camera model, the others are extrapolated.
  std::vector<Eigen::Vector2d> vertices;
  std::vector<bool> is_needed;  ///< interpolation of valid pixels uses it
  /// Source positions of all output pixels, row-major; NaN if invalid.
  std::vector<Eigen::Vector2d> sources;
};

/// A mesh in the number format of an engine.
struct UnitMesh {
  std::vector<std::pair<std::string, std::string>> files;
  std::string configuration;  ///< how to configure the engine for the files
  /// Source positions after quantization, in raygrid's pixel coordinates.
  std::vector<Eigen::Vector2d> vertices;
  bool keeps_rows = false;  ///< the files contain no y coordinates
};

/// A dewarping engine.
struct MeshUnit {
  /// Throws Error(kUsage) for sizes and steps that the engine does not support.
  MeshLattice (*lattice)(const MeshRequest& request) = nullptr;
  /// Throws Error(kQualityTooLow) if a displacement exceeds the engine's range.
  UnitMesh (*write)(const MeshTable& mesh) = nullptr;
  /// Default of --max-fit-error-px, and the reason for this limit, which the
  /// error message includes.
  std::optional<double> max_error_px;
  std::string reason;
  /// Modes of interpolation between vertices, along both axes. If the engine's
  /// documentation does not specify the mode, this lists all candidates, and
  /// the largest error is reported.
  std::vector<MeshInterpolation> interpolations = {MeshInterpolation::kLine};
};

/// Difference between the source positions that the engine computes and those
/// of the camera model.
struct MeshError {
  double max_px = 0, rms_px = 0;
  int x = 0, y = 0;       ///< output pixel with the largest error
  size_t num_pixels = 0;  ///< output pixels with a source
  /// Output pixels without a source for which the engine reads inside the
  /// image.
  size_t num_filled = 0;
  /// Needed vertices that quantization or clamping moves by more than 1 px.
  size_t num_inaccurate = 0;
};

/// Interpolates a source position bilinearly between four vertices.
Eigen::Vector2d MapToMesh(const MeshLattice& lattice,
                          const std::vector<Eigen::Vector2d>& vertices,
                          const MeshStep& x, const MeshStep& y);

MeshError ComputeMeshError(const MeshTable& mesh, const UnitMesh& unit,
                           MeshInterpolation interpolation);
/// Formats an error, e.g. "error 0.051 px max (at 3, 8), 0.022 px RMS", and the
/// numbers of filled pixels and clamped vertices.
std::string FormatMeshError(const MeshError& error);

// ---- For implementations of engines ---------------------------------------

/// Returns a grid with cells of step_x x step_y pixels from pixel (0, 0) on
/// that covers the output image.
MeshLattice MakeRegularLattice(const ImageSize& size, int step_x, int step_y);

/// Range of a side of an image, in pixels. RequireMeshSize() throws
/// Error(kUsage) with the engine's name if a side is outside its range or not a
/// multiple.
struct MeshSides {
  int min = 1, max = 65535, multiple = 1;
};
void RequireMeshSize(const std::string& unit, const std::string& what,
                     const ImageSize& size, const MeshSides& width,
                     const MeshSides& height);

/// Converts raygrid's pixel coordinates to and from those of engines, in which
/// the centre of the first pixel is (0, 0).
inline Eigen::Vector2d ToMeshUnit(const Eigen::Vector2d& pixel) {
  return ToProgram(PixelOrigin::kFirstPixelCenter, {}, pixel);
}
inline Eigen::Vector2d FromMeshUnit(const Eigen::Vector2d& position) {
  return FromProgram(PixelOrigin::kFirstPixelCenter, {}, position);
}

/// Returns round(value scale), clamped to [least, most].
int64_t FixedPoint(double value, int scale, int64_t least, int64_t most);

/// Appends the num_bytes least significant bytes of a number, little-endian.
void AppendLittleEndian(uint64_t number, int num_bytes, std::string* bytes);

/// Inserts a suffix before the extension: "front.bin" -> "front_meshxi.bin".
std::string PathWithSuffix(const std::string& path, const std::string& suffix);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_MESH_MESH_H
