/// Meshes of hardware that dewarps: the places that a view's pixels show, at a
/// lattice of these, as a unit holds them and goes on between them.
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

/// Pixels of the view at which a mesh has vertices. The last ones may lie
/// beyond it.
struct MeshLattice {
  std::vector<int> x, y;

  int columns() const { return static_cast<int>(x.size()); }
  int rows() const { return static_cast<int>(y.size()); }
  size_t num_vertices() const { return x.size() * y.size(); }
};

/// A pixel on the way from one vertex of an axis to the next.
struct MeshStep {
  int vertex = 0;
  double part = 0;  ///< of the way
};
/// Those of the first so many pixels of an axis.
std::vector<MeshStep> StepsAlong(const std::vector<int>& vertices, int count);

/// How a unit goes on between the vertices of an axis.
enum class MeshSpan {
  kLine,    ///< straight, from each to the next
  kPatch,   ///< parabolas through three, each ending where the next one begins
  kNearest  ///< the parabola through the nearest one and those beside it
};
/// "lines", "patches" or "nearest".
std::string SpanName(MeshSpan span);

/// Three vertices of an axis, from one on, and what they weigh at a pixel.
struct MeshWeights {
  int vertex = 0;
  std::array<double, 3> weights = {0, 0, 0};
};
/// Those at the first so many pixels of an axis. Vertices of parabolas are
/// evenly spaced.
std::vector<MeshWeights> WeightsAlong(const std::vector<int>& vertices,
                                      int count, MeshSpan span);

/// The view of a mesh that is asked for.
struct MeshRequest {
  ImageSize size, source_size;
  std::optional<int> step;  ///< of pixels between vertices, if it was given
};

/// A mesh before a unit: exact, in raygrid's pixels.
struct MeshTable {
  std::string path;
  ImageSize size, source_size;
  MeshLattice lattice;
  /// The places that the vertices show, row by row, all of them finite. The
  /// camera answers for those that pixels with a source lie at; the others
  /// continue them.
  std::vector<Eigen::Vector2d> vertices;
  std::vector<bool> is_needed;  ///< whether such a pixel lies at a vertex
  /// Of all pixels of the view, row by row; NaN where there is none.
  std::vector<Eigen::Vector2d> sources;
};

/// A mesh as a unit holds it.
struct UnitMesh {
  std::vector<std::pair<std::string, std::string>> files;
  std::string configuration;  ///< what the user needs besides the files
  /// The places that the numbers in the files say, in raygrid's pixels.
  std::vector<Eigen::Vector2d> vertices;
  bool keeps_rows = false;  ///< y is not in the files
};

/// A dewarping unit.
struct MeshUnit {
  /// Throws Error(kUsage) for sizes and steps that the unit cannot take.
  MeshLattice (*lattice)(const MeshRequest& request) = nullptr;
  /// Throws Error(kQuality) for places that the unit cannot reach.
  UnitMesh (*write)(const MeshTable& mesh) = nullptr;
  /// The largest error that is let through unless the user says another one,
  /// and why there is one.
  std::optional<double> max_error_px;
  std::string reason;
  /// How it goes on between vertices, the same way along both axes. Several, if
  /// its documents leave that open: its error is the largest of theirs.
  std::vector<MeshSpan> spans = {MeshSpan::kLine};
};

/// The places that a unit shows, compared with those of the view.
struct MeshError {
  double max_px = 0, rms_px = 0;
  int x = 0, y = 0;       ///< the pixel of the view that is farthest off
  size_t num_pixels = 0;  ///< that have a source
  /// Pixels that show the camera's image where the view has no source.
  size_t num_filled = 0;
  /// Needed vertices that the unit holds more than a pixel off.
  size_t num_moved = 0;
};

/// The place that vertices say of a pixel, bilinearly between four of them.
Eigen::Vector2d MapToMesh(const MeshLattice& lattice,
                          const std::vector<Eigen::Vector2d>& vertices,
                          const MeshStep& x, const MeshStep& y);

MeshError ComputeMeshError(const MeshTable& mesh, const UnitMesh& unit,
                           MeshSpan span);
/// "at most 0.051 px, 0.022 px (RMS) from the view", and what else is off.
std::string FormatMeshError(const MeshError& error);

// ---- For units -------------------------------------------------------------

/// The lattice of cells that begin at the first pixel and cover the view.
MeshLattice MakeRegularLattice(const ImageSize& size, int step_x, int step_y);

/// Throws Error(kUsage), naming the unit, if a side of a view or an image is
/// not in a range, or no multiple.
struct MeshSides {
  int min = 1, max = 65535, multiple = 1;
};
void RequireMeshSize(const std::string& unit, const std::string& what,
                     const ImageSize& size, const MeshSides& width,
                     const MeshSides& height);

/// Every vertex passes one of these two. Units count from the first pixel's
/// centre.
inline Eigen::Vector2d ToMeshUnit(const Eigen::Vector2d& pixel) {
  return ToProgram(PixelOrigin::kFirstPixelCenter, {}, pixel);
}
inline Eigen::Vector2d FromMeshUnit(const Eigen::Vector2d& position) {
  return FromProgram(PixelOrigin::kFirstPixelCenter, {}, position);
}

/// A number in steps of 1 / scale, the nearest between two bounds.
int64_t FixedPoint(double value, int scale, int64_t least, int64_t most);

/// The lowest so many bytes of a number, the lowest first.
void AppendLittleEndian(uint64_t number, int num_bytes, std::string* bytes);

/// "front_meshxi.bin" beside "front.bin".
std::string PathWithSuffix(const std::string& path, const std::string& suffix);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_MESH_MESH_H
