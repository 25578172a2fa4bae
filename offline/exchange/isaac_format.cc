#include "exchange/isaac_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "dataset/error.h"
#include "dataset/parallel_for.h"
#include "exchange/exr.h"
#include "exchange/mesh/mesh.h"
#include "exchange/pixel_origin.h"

namespace raygrid {
namespace {

constexpr char kFrontSuffix[] = "ahead", kRearSuffix[] = "behind";

// Converts a direction between the renderer's axes (x right, y up, z backward)
// and the camera's; the conversion is its own inverse.
Eigen::Vector3d SwapAxes(const Eigen::Vector3d& direction) {
  return {direction.x(), -direction.y(), -direction.z()};
}

// Returns the normalized image coordinates: (0, 0) is the top-left image
// corner, (1, 1) the bottom-right.
Eigen::Vector2d ToUnitImage(const ImageSize& size,
                            const Eigen::Vector2d& pixel) {
  return ToProgram(PixelOrigin::kImageCorner, size, pixel)
      .cwiseQuotient(Eigen::Vector2d(size.width, size.height));
}
Eigen::Vector2d FromUnitImage(const ImageSize& size,
                              const Eigen::Vector2d& position) {
  return FromProgram(
      PixelOrigin::kImageCorner, size,
      position.cwiseProduct(Eigen::Vector2d(size.width, size.height)));
}

// Octahedral map of all directions to the square from (-1, -1) to (1, 1),
// projected along z; the far half is folded outwards. The centre of the square
// is the viewing direction or its opposite.
class Octahedron {
 public:
  explicit Octahedron(bool is_ahead) : sign_(is_ahead ? -1 : 1) {}

  Eigen::Vector2d ProjectDirection(const Eigen::Vector3d& direction) const {
    const Eigen::Vector3d on_it = direction / direction.lpNorm<1>();
    return sign_ * on_it.z() < 0 ? FoldHemisphere(on_it.head<2>())
                                 : on_it.head<2>();
  }
  Eigen::Vector3d DirectionAt(const Eigen::Vector2d& position) const {
    const double height = 1 - position.lpNorm<1>();
    const Eigen::Vector2d across =
        height < 0 ? FoldHemisphere(position) : position;
    return Eigen::Vector3d(across.x(), across.y(), sign_ * height).normalized();
  }

 private:
  static Eigen::Vector2d FoldHemisphere(const Eigen::Vector2d& position) {
    return {std::copysign(1 - std::abs(position.y()), position.x()),
            std::copysign(1 - std::abs(position.x()), position.y())};
  }

  double sign_;
};

// ---- Errors ----------------------------------------------------------------

struct LookupError {
  double max_px = 0, sum = 0;
  Eigen::Vector2d at = {0, 0};
  size_t count = 0;
  size_t num_lost = 0;  ///< pixels that lack a valid neighbouring texel

  void Add(double px, const Eigen::Vector2d& pixel) {
    if (px > max_px) at = pixel;
    max_px = std::max(max_px, px);
    sum += px * px;
    ++count;
  }
  void Add(const LookupError& other) {
    if (other.max_px > max_px) at = other.at;
    max_px = std::max(max_px, other.max_px);
    sum += other.sum;
    count += other.count;
    num_lost += other.num_lost;
  }
  double rms_px() const {
    return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0;
  }
  std::string Text() const {
    return fmt::format("{:.2g} px max (at {:g}, {:g}), {:.2g} px RMS", max_px,
                       at.x(), at.y(), rms_px());
  }
};

bool IsValid(const ExportedCamera& table, const Eigen::Vector2d& pixel) {
  return table.camera->IsInImageCircle(pixel) &&
         (!table.valid_region || table.valid_region->IsValidAt(pixel));
}

// ---- From pixels to directions ---------------------------------------------

constexpr size_t kUnprojectionChannels = 3, kProjectionChannels = 2;

// Marks invalid pixels: the renderer ignores rays that point backward.
const Eigen::Vector3d kNoRay(0, 0, 1);

// Returns the directions of all pixels in the renderer's axes.
std::vector<float> MakeUnprojectionTable(const ExportedCamera& table) {
  const ImageSize& size = table.camera->image_size();
  std::vector<float> numbers(kUnprojectionChannels * size.width * size.height);
  ParallelFor(size.height, NumThreads(table.num_threads), [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      const Eigen::Vector2d pixel(x, y);
      const auto seen = table.camera->IsInImageCircle(pixel)
                            ? table.camera->Unproject(pixel)
                            : std::nullopt;
      const Eigen::Vector3d ray = seen ? SwapAxes(seen->normalized()) : kNoRay;
      for (size_t c = 0; c < kUnprojectionChannels; ++c)
        numbers[kUnprojectionChannels *
                    (static_cast<size_t>(y) * size.width + x) +
                c] = static_cast<float>(ray[c]);
    }
  });
  return numbers;
}

Eigen::Vector3d InterpolateUnprojection(const ImageSize& size,
                                        const std::vector<float>& numbers,
                                        int x, int y) {
  const float* const at = &numbers[kUnprojectionChannels *
                                   (static_cast<size_t>(y) * size.width + x)];
  return {at[0], at[1], at[2]};
}

bool HasRay(const Eigen::Vector3d& ray) { return ray != kNoRay; }

// Returns the interpolation error of the table: distance between the projected
// mean ray of four neighbouring pixels and their centre, where all four are
// valid.
LookupError ComputeUnprojectionError(const ExportedCamera& table,
                                     const std::vector<float>& numbers) {
  constexpr int kPixelsAcross = 160;
  const ImageSize& size = table.camera->image_size();
  const int step =
      std::max(1, std::max(size.width, size.height) / kPixelsAcross);
  LookupError error;
  for (int y = 0; y + 1 < size.height; y += step)
    for (int x = 0; x + 1 < size.width; x += step) {
      Eigen::Vector3d sum(0, 0, 0);
      bool is_known = true;
      for (const auto& [i, j] :
           {std::pair(x, y), {x + 1, y}, {x, y + 1}, {x + 1, y + 1}}) {
        const Eigen::Vector3d ray =
            InterpolateUnprojection(size, numbers, i, j);
        is_known =
            is_known && HasRay(ray) && IsValid(table, Eigen::Vector2d(i, j));
        sum += ray;
      }
      const Eigen::Vector2d position(x + 0.5, y + 0.5);
      const auto seen = is_known
                            ? table.camera->Project(SwapAxes(sum), &position, 1)
                            : std::nullopt;
      if (seen) error.Add((*seen - position).norm(), position);
    }
  return error;
}

// ---- From directions to pixels ---------------------------------------------

// A cell of four neighbouring texels, and the fractional position in it.
struct TexelCell {
  int x = 0, y = 0;
  Eigen::Vector2d part = {0, 0};

  // The table has side x side texels; (-1, -1) is its outer corner.
  static TexelCell At(const Eigen::Vector2d& position, int side) {
    TexelCell cell;
    cell.x = SliceAlong(position.x(), side, &cell.part.x());
    cell.y = SliceAlong(position.y(), side, &cell.part.y());
    return cell;
  }

 private:
  // Returns the index of the texel before a coordinate, and in *rest the
  // fraction.
  static int SliceAlong(double position, int side, double* rest) {
    const double texel = std::clamp((position + 1) / 2 * side - 0.5, 0.0,
                                    static_cast<double>(side - 1));
    const int first = std::min(static_cast<int>(texel), side - 2);
    *rest = texel - first;
    return first;
  }
};

Eigen::Vector2d TexelCenter(int x, int y, int side) {
  return Eigen::Vector2d(2 * x + 1 - side, 2 * y + 1 - side) / side;
}

// Returns the maximum angle between the rays of neighbouring pixels, in
// radians.
double ComputeMaxStep(const ImageSize& size, const std::vector<float>& enter) {
  double largest = 0;
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const Eigen::Vector3d ray = InterpolateUnprojection(size, enter, x, y);
      for (const auto& [i, j] : {std::pair(x - 1, y), {x, y - 1}}) {
        if (std::min(i, j) < 0 || !HasRay(ray)) continue;
        const Eigen::Vector3d other =
            InterpolateUnprojection(size, enter, i, j);
        if (HasRay(other)) largest = std::max(largest, (ray - other).norm());
      }
    }
  return largest;
}

// Projects directions of the renderer. Failing projections are slow, so only
// directions near the pixels' rays are projected.
class ProjectionSampler {
 public:
  ProjectionSampler(const ExportedCamera& table,
                    const std::vector<float>& enter)
      : camera_(*table.camera),
        octahedron_(table.model == kFrontSuffix),
        mask_side_(MaskSide(ComputeMaxStep(table.camera->image_size(), enter))),
        is_near_pixel_ray_(static_cast<size_t>(mask_side_) * mask_side_,
                           false) {
    for (size_t k = 0; k < enter.size(); k += kUnprojectionChannels) {
      const Eigen::Vector3d ray(enter[k], enter[k + 1], enter[k + 2]);
      if (HasRay(ray)) MarkNearTexels(ray);
    }
  }

  const Octahedron& octahedron() const { return octahedron_; }

  std::optional<Eigen::Vector2d> ProjectDirection(
      const Eigen::Vector3d& direction, const Eigen::Vector2d* start) const {
    if (!IsNear(direction)) return std::nullopt;
    return camera_.Project(SwapAxes(direction), start, 0);
  }
  // Also projects to positions outside the image, so that the image edge can
  // lie between two texels.
  std::optional<Eigen::Vector2d> ProjectNear(
      const Eigen::Vector3d& direction, const Eigen::Vector2d& start) const {
    constexpr double kMarginPx = 64;
    const auto position = ProjectDirection(direction, &start);
    return position ? position
                    : camera_.Project(SwapAxes(direction), &start, kMarginPx);
  }

 private:
  // Returns the number of mask cells per side: cells are twice as wide as the
  // largest step between pixels, within limits.
  static int MaskSide(double step_rad) {
    constexpr double kLeast = 17, kMost = 1025;
    return static_cast<int>(std::clamp(1 / step_rad, kLeast, kMost));
  }

  void MarkNearTexels(const Eigen::Vector3d& ray) {
    const TexelCell cell =
        TexelCell::At(octahedron_.ProjectDirection(ray), mask_side_);
    for (int j = std::max(cell.y - 1, 0);
         j <= std::min(cell.y + 2, mask_side_ - 1); ++j)
      for (int i = std::max(cell.x - 1, 0);
           i <= std::min(cell.x + 2, mask_side_ - 1); ++i)
        is_near_pixel_ray_[j * mask_side_ + i] = true;
  }
  bool IsNear(const Eigen::Vector3d& direction) const {
    const TexelCell cell =
        TexelCell::At(octahedron_.ProjectDirection(direction), mask_side_);
    const int first = cell.y * mask_side_ + cell.x;
    return is_near_pixel_ray_[first] || is_near_pixel_ray_[first + 1] ||
           is_near_pixel_ray_[first + mask_side_] ||
           is_near_pixel_ray_[first + mask_side_ + 1];
  }

  const CameraModel& camera_;
  Octahedron octahedron_;
  int mask_side_;
  std::vector<bool> is_near_pixel_ray_;
};

// Returns an invalid position outside the image, near the corner closest to a
// direction. Positions interpolated between it and another one outside the
// image are outside, too.
Eigen::Vector2d MakeInvalidPosition(const Eigen::Vector3d& direction) {
  const Eigen::Vector3d seen = SwapAxes(direction);
  return {seen.x() < 0 ? -1 : 2, seen.y() < 0 ? -1 : 2};
}
bool IsInvalidPosition(const Eigen::Vector2d& position) {
  return (position.x() == -1 || position.x() == 2) &&
         (position.y() == -1 || position.y() == 2);
}

// A square table of image positions, one per texel.
class ProjectionTexels {
 public:
  ProjectionTexels(const ProjectionSampler& projection, const ImageSize& size,
                   int side)
      : projection_(projection),
        size_(size),
        side_(side),
        numbers_(kProjectionChannels * side * side) {}

  void Fill(int num_threads) {
    ParallelFor(side_, num_threads, [&](int y) {
      std::optional<Eigen::Vector2d> last;
      for (int x = 0; x < side_; ++x) {
        const Eigen::Vector3d direction = ComputeDirection(x, y);
        last = projection_.ProjectDirection(direction, last ? &*last : nullptr);
        Set(x, y,
            last ? ToUnitImage(size_, *last) : MakeInvalidPosition(direction));
      }
    });
  }

  // Extrapolates: assigns positions outside the image to texels that neighbour
  // a valid one.
  void Widen(int num_threads) {
    std::vector<std::vector<std::pair<int, Eigen::Vector2d>>> found(side_);
    ParallelFor(side_, num_threads, [&](int y) {
      for (int x = 0; x < side_; ++x) {
        const auto start =
            IsInvalidPosition(At(x, y)) ? ProjectNeighbor(x, y) : std::nullopt;
        const auto position =
            start ? projection_.ProjectNear(ComputeDirection(x, y), *start)
                  : std::nullopt;
        if (position) found[y].emplace_back(x, ToUnitImage(size_, *position));
      }
    });
    for (int y = 0; y < side_; ++y)
      for (const auto& [x, position] : found[y]) Set(x, y, position);
  }

  Eigen::Vector2d At(int x, int y) const {
    const float* const at = &numbers_[IndexOf(x, y)];
    return {at[0], at[1]};
  }
  const std::vector<float>& numbers() const { return numbers_; }

 private:
  size_t IndexOf(int x, int y) const {
    return kProjectionChannels * (static_cast<size_t>(y) * side_ + x);
  }
  void Set(int x, int y, const Eigen::Vector2d& position) {
    for (size_t c = 0; c < kProjectionChannels; ++c)
      numbers_[IndexOf(x, y) + c] = static_cast<float>(position[c]);
  }
  Eigen::Vector3d ComputeDirection(int x, int y) const {
    return projection_.octahedron().DirectionAt(TexelCenter(x, y, side_));
  }
  // Returns the pixel of a valid neighbouring texel.
  std::optional<Eigen::Vector2d> ProjectNeighbor(int x, int y) const {
    for (int j = std::max(y - 1, 0); j <= std::min(y + 1, side_ - 1); ++j)
      for (int i = std::max(x - 1, 0); i <= std::min(x + 1, side_ - 1); ++i)
        if (!IsInvalidPosition(At(i, j))) return FromUnitImage(size_, At(i, j));
    return std::nullopt;
  }

  const ProjectionSampler& projection_;
  ImageSize size_;
  int side_;
  std::vector<float> numbers_;
};

// Two rings are extrapolated because an image corner may lie in a cell none of
// whose texels is in the image.
ProjectionTexels MakeProjectionTexels(const ProjectionSampler& projection,
                                      const ExportedCamera& table, int side) {
  constexpr int kRings = 2;
  const int num_threads = NumThreads(table.num_threads);
  ProjectionTexels texels(projection, table.camera->image_size(), side);
  texels.Fill(num_threads);
  for (int k = 0; k < kRings; ++k) texels.Widen(num_threads);
  return texels;
}

Eigen::Vector2d InterpolateBilinear(
    const std::array<Eigen::Vector2d, 4>& corners,
    const Eigen::Vector2d& part) {
  const Eigen::Vector2d above =
      corners[0] + part.x() * (corners[1] - corners[0]);
  const Eigen::Vector2d below =
      corners[2] + part.x() * (corners[3] - corners[2]);
  return above + part.y() * (below - above);
}

// Interpolates the image position of a direction in a table of side x side
// texels, with the values texel(x, y). Returns nullopt if one of the four
// neighbouring texels is invalid.
template <typename Texel>
std::optional<Eigen::Vector2d> InterpolateTable(
    const Octahedron& octahedron, int side, const Eigen::Vector3d& direction,
    const Texel& texel) {
  const TexelCell cell =
      TexelCell::At(octahedron.ProjectDirection(direction), side);
  std::array<Eigen::Vector2d, 4> corners;
  for (int k = 0; k < 4; ++k) {
    corners[k] = texel(cell.x + k % 2, cell.y + k / 2);
    if (IsInvalidPosition(corners[k])) return std::nullopt;
  }
  return InterpolateBilinear(corners, cell.part);
}

// Adds the round-trip error of one pixel: its ray, from the other table, is
// looked up in this table and compared with the pixel.
template <typename Texel>
void AddLookup(const ExportedCamera& table, const ProjectionSampler& projection,
               const std::vector<float>& enter, int side, int x, int y,
               const Texel& texel, LookupError* error) {
  const ImageSize& size = table.camera->image_size();
  const Eigen::Vector3d ray = InterpolateUnprojection(size, enter, x, y);
  const Eigen::Vector2d pixel(x, y);
  if (!HasRay(ray) || !IsValid(table, pixel)) return;
  const auto position =
      InterpolateTable(projection.octahedron(), side, ray, texel);
  if (position)
    error->Add((FromUnitImage(size, *position) - pixel).norm(), pixel);
  else
    ++error->num_lost;
}

// Predicts the error of a table from a subset of pixels, without computing the
// table.
LookupError PredictProjectionError(const ExportedCamera& table,
                                   const ProjectionSampler& projection,
                                   const std::vector<float>& enter, int side) {
  constexpr int kPixelsAcross = 40;
  const ImageSize& size = table.camera->image_size();
  const int step =
      std::max(1, std::max(size.width, size.height) / kPixelsAcross);
  LookupError error;
  for (int y = 0; y < size.height; y += step)
    for (int x = 0; x < size.width; x += step) {
      const Eigen::Vector2d start(x, y);
      AddLookup(
          table, projection, enter, side, x, y,
          [&](int i, int j) -> Eigen::Vector2d {
            const Eigen::Vector3d direction =
                projection.octahedron().DirectionAt(TexelCenter(i, j, side));
            const auto position = projection.ProjectNear(direction, start);
            return position ? ToUnitImage(size, *position)
                            : MakeInvalidPosition(direction);
          },
          &error);
    }
  return error;
}

// Measures the error of a table at all valid pixels.
LookupError ComputeProjectionError(const ExportedCamera& table,
                                   const ProjectionSampler& projection,
                                   const std::vector<float>& enter,
                                   const ProjectionTexels& texels, int side) {
  const ImageSize& size = table.camera->image_size();
  std::vector<LookupError> rows(size.height);
  ParallelFor(size.height, NumThreads(table.num_threads), [&](int y) {
    for (int x = 0; x < size.width; ++x)
      AddLookup(
          table, projection, enter, side, x, y,
          [&](int i, int j) { return texels.At(i, j); }, &rows[y]);
  });
  LookupError error;
  for (const LookupError& row : rows) error.Add(row);
  return error;
}

// ---- The pair --------------------------------------------------------------

// Positions have kinks at the octahedron's edges, some of which lie on the
// axes. With an odd number of texels, a row of texels lies there, too.
constexpr std::array<int, 5> kProjectionTableSides = {257, 513, 1025, 2049,
                                                      4097};
// The largest table is slow to compute; it is used only if it helps.
constexpr int kDefaultProjectionTableSide = 2049;
constexpr double kDefaultMaxErrorPx = 0.01;

struct ProjectionTableChoice {
  int side = 0;
  std::vector<float> numbers;
  LookupError error;
};

ProjectionTableChoice MakeProjectionTable(const ExportedCamera& table,
                                          const ProjectionSampler& projection,
                                          const std::vector<float>& enter,
                                          int side) {
  const ProjectionTexels texels = MakeProjectionTexels(projection, table, side);
  return {side, texels.numbers(),
          ComputeProjectionError(table, projection, enter, texels, side)};
}

// Chooses the smallest table within the tolerance, or the usual size if there
// is none. If the user requests a tolerance that no size meets, no table is
// computed, and the error is the predicted one.
ProjectionTableChoice ChooseProjectionTable(const ExportedCamera& table,
                                            const std::vector<float>& enter) {
  const double aim_px = table.max_error_px.value_or(kDefaultMaxErrorPx);
  const ProjectionSampler projection(table, enter);
  const auto is_near = [&](const LookupError& error) {
    return error.max_px <= aim_px && error.num_lost == 0;
  };
  ProjectionTableChoice made, expected;
  for (const int side : kProjectionTableSides) {
    expected = {
        side, {}, PredictProjectionError(table, projection, enter, side)};
    if (!is_near(expected.error)) continue;
    made = MakeProjectionTable(table, projection, enter, side);
    if (is_near(made.error)) break;
  }
  if (!made.numbers.empty()) return made;
  if (table.max_error_px) return expected;
  return MakeProjectionTable(table, projection, enter,
                             kDefaultProjectionTableSide);
}

std::string FormatProjectionTable(const ProjectionTableChoice& choice) {
  std::string text = choice.error.Text();
  if (choice.error.num_lost > 0)
    text +=
        fmt::format("; {} pixels cannot be represented", choice.error.num_lost);
  return text;
}

void RequireSmallProjectionError(const ExportedCamera& table,
                                 const ProjectionTableChoice& choice) {
  if (!table.max_error_px || (choice.error.max_px <= *table.max_error_px &&
                              choice.error.num_lost == 0))
    return;
  throw Error(ExitCode::kQualityTooLow,
              fmt::format("isaac: the error exceeds {:g} px even with the "
                          "largest table of {} x {} directions: {}",
                          *table.max_error_px, choice.side, choice.side,
                          FormatProjectionTable(choice)));
}

TableOutput WriteIsaac(const ExportedCamera& table) {
  const ImageSize& size = table.camera->image_size();
  const std::vector<float> enter = MakeUnprojectionTable(table);
  const LookupError enter_error = ComputeUnprojectionError(table, enter);
  const ProjectionTableChoice exit = ChooseProjectionTable(table, enter);
  RequireSmallProjectionError(table, exit);
  const std::string enter_path = PathWithSuffix(table.path, "_enter"),
                    exit_path = PathWithSuffix(table.path, "_exit");
  TableOutput output;
  output.files = {
      {enter_path, WriteExr(size, {"R", "G", "B"}, enter)},
      {exit_path, WriteExr({exit.side, exit.side}, {"R", "G"}, exit.numbers)}};
  output.configuration = fmt::format(
      "{}: {} x {} rays, interpolation error {}; {}: {} x {} directions, error "
      "{}; set omni:lensdistortion:lut: nominalWidth {}, nominalHeight {}, "
      "opticalCenter ({:g}, {:g})",
      enter_path, size.width, size.height, enter_error.Text(), exit_path,
      exit.side, exit.side, FormatProjectionTable(exit), size.width,
      size.height, size.width / 2.0, size.height / 2.0);
  output.metrics = {{"enter_max_px", enter_error.max_px},
                    {"enter_rms_px", enter_error.rms_px()},
                    {"exit_side", exit.side},
                    {"exit_max_px", exit.error.max_px},
                    {"exit_rms_px", exit.error.rms_px()},
                    {"pixels", static_cast<double>(exit.error.count)},
                    {"pixels_lost", static_cast<double>(exit.error.num_lost)}};
  return output;
}

}  // namespace

TableFormat MakeIsaacFormat() {
  TableFormat format;
  format.name = "isaac";
  format.holds =
      "Isaac Sim: NAME_enter.exr (pixels to rays) and NAME_exit.exr "
      "(directions to pixels)";
  format.endings = {".exr"};
  format.options = {"model", "max-fit-error-px"};
  format.models = {kFrontSuffix, kRearSuffix};
  format.write_camera = WriteIsaac;
  return format;
}

}  // namespace raygrid
