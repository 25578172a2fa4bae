#include "features/refinement/outliers.h"

#include <algorithm>
#include <optional>

#include "features/board_view/lattice_camera.h"
#include "features/board_view/local_mapping.h"

namespace raygrid {
namespace {

// Returns an additional tolerance for features whose square is larger than the
// window, which contains no other feature: the uncertainty of the prediction,
// estimated by its difference from that of a lower degree.
double ComputeToleratedErrorPx(const std::vector<Correspondence>& around,
                               const LocalMapping& predicted, int degree,
                               int window_px) {
  constexpr double kMaxSquares = 0.3;
  const double max_distance_px = kMaxSquares * predicted.SpacingPx();
  if (predicted.SpacingPx() < window_px) return 0;
  if (degree == 1) return max_distance_px;  // curvature unknown
  LocalMapping lower;
  if (FitLocalMapping(around, degree - 1, &lower) == 0) return 0;
  return std::min(max_distance_px, (lower.center - predicted.center).norm());
}

// Computes the relative deviations of features of one lattice, from which
// outliers are removed meanwhile.
class LineOutlierFilter {
 public:
  LineOutlierFilter(const Board& board, const ImageSize& size,
                    const Tolerance& tolerance, int window_px,
                    const FeatureLattice& lattice)
      : board_(board),
        size_(size),
        tolerance_(tolerance),
        window_px_(window_px),
        lattice_(lattice) {}

  // Returns the distance of a feature from its prediction by the neighbours,
  // relative to the tolerance; 0 if there are too few neighbours.
  double ComputeRelativeDeviation(int column, int row) {
    LocalMapping predicted;
    const auto around = lattice_.Around(column, row, 2, false);
    const int degree = FitLocalMapping(around, 3, &predicted);
    if (around.size() < 4 || degree == 0) return 0;
    const double tolerance_px =
        tolerance_.px + tolerance_.squares * predicted.SpacingPx();
    // Fewer neighbours, often on one side only, predict less accurately.
    const double slack = around.size() >= 12 ? 1 : around.size() >= 8 ? 2 : 4;
    const Eigen::Vector2d& pixel = lattice_.at(column, row);
    const double deviation =
        (pixel - predicted.center).norm() / (tolerance_px * slack);
    if (deviation <= 1) return deviation;
    double least = deviation;
    LocalMapping in_perspective;
    if (FitPerspectiveMapping(around, 2, &in_perspective))
      least = std::min(least, (pixel - in_perspective.center).norm() /
                                  (tolerance_px * slack));
    if (least > 1)
      if (const auto seen = PredictWithCamera(column, row))
        least = std::min(least, (pixel - *seen).norm() / tolerance_px);
    if (least <= 1) return least;
    const double doubt_px =
        ComputeToleratedErrorPx(around, predicted, degree, window_px_);
    return least * std::min(1.0, tolerance_px * slack / doubt_px);
  }

 private:
  std::optional<Eigen::Vector2d> PredictWithCamera(int column, int row) {
    // Tag corners of an AprilGrid are not evenly spaced.
    if (!is_camera_fitted_ && !board_.IsTagGrid())
      lens_ = LatticeCamera::Fit(lattice_.Features(), size_);
    is_camera_fitted_ = true;
    return lens_ ? lens_->Project(Eigen::Vector2d(column, row)) : std::nullopt;
  }

  const Board& board_;
  ImageSize size_;
  Tolerance tolerance_;
  int window_px_;
  const FeatureLattice& lattice_;
  bool is_camera_fitted_ = false;
  std::optional<LatticeCamera> lens_;
};

}  // namespace

void Reject(const Board& board, int column, int row, const std::string& reason,
            FeatureLattice* lattice, ImageDetection* detection) {
  detection->rejected.push_back(
      {{board.id, column, row, lattice->at(column, row)}, reason});
  lattice->Remove(column, row);
}

void RejectOutliers(const Board& board, const ImageSize& size,
                    const Tolerance& tolerance, int window_px,
                    FeatureLattice* lattice, ImageDetection* detection) {
  LineOutlierFilter outlier_filter(board, size, tolerance, window_px, *lattice);
  for (;;) {
    double worst = 1;
    int worst_column = -1, worst_row = -1;
    for (const Feature& f : lattice->Features()) {
      const double deviation =
          outlier_filter.ComputeRelativeDeviation(f.column, f.row);
      if (deviation <= worst) continue;
      worst = deviation;
      worst_column = f.column;
      worst_row = f.row;
    }
    if (worst_column < 0) return;
    Reject(board, worst_column, worst_row, kNotCollinear, lattice, detection);
  }
}

}  // namespace raygrid
