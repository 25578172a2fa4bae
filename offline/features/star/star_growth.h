#ifndef RAYGRID_FEATURES_STAR_STAR_GROWTH_H
#define RAYGRID_FEATURES_STAR_STAR_GROWTH_H

#include <Eigen/Core>
#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "features/board_view/detection.h"
#include "features/board_view/feature_lattice.h"
#include "features/board_view/lattice_camera.h"
#include "features/board_view/tag_detection.h"
#include "features/refinement/matching_refinement.h"
#include "features/refinement/symmetry_mask.h"

namespace raygrid {

/// Minimum number of stars of an accepted board.
constexpr int kMinStarsOnBoard = 5;

/// A detected tag that belongs to the board.
struct VisibleTag {
  BoardTag tag;
  std::array<Eigen::Vector2d, 4> corners;
  Eigen::Matrix3d homography;  ///< from squares to pixels
};

/// Returns the corners of a tag's black square, clockwise from the top left, in
/// squares.
std::array<Eigen::Vector2d, 4> CornersOnBoard(const BoardTag& tag);

/// Returns the detected tags that belong to a board.
std::vector<VisibleTag> FindVisibleTags(
    const Board& board, const std::vector<DetectedTag>& detected);

/// Detects the stars of one board, starting from known stars or tags.
class StarGrowth {
 public:
  /// Keeps references. masks: one per feature of the board, or one for all.
  StarGrowth(const GreyImage& image, const Board& board,
             const StarTexture& texture, const std::vector<SymmetryMask>& masks,
             const DetectionOptions& options, std::vector<VisibleTag> tags);

  /// Sets a known star.
  void Set(int column, int row, const Eigen::Vector2d& pixel) {
    lattice_.Set(column, row, pixel);
  }
  /// Requires the correlation of a star with the rendered star to be at least
  /// this fraction of its neighbours' mean correlation.
  void SetMinCorrelationRatio(double part) { min_correlation_ratio_ = part; }
  /// Searches for a star within search_squares of its predicted position;
  /// returns whether it was found.
  bool Try(int column, int row, const LocalMapping& mapping,
           double search_squares, double min_correlation);
  /// Searches around tags, then next to each detected star, until no more are
  /// found.
  void Grow();
  /// Searches for stars that the lens model fitted to the lattice predicts
  /// across gaps, such as a tag at the image's edge, and then for their
  /// neighbours.
  void GrowAcrossGaps();

  /// Whether the stars around each tag are consistent with its corners.
  bool AgreesWithTags() const;
  /// Whether there are enough stars, with at most max_in_vain unsuccessful
  /// searches per star.
  bool HasFewFailures(double max_in_vain) const;

  const FeatureLattice& lattice() const { return lattice_; }
  /// Returns the positions of unsuccessful searches, with the reasons.
  std::vector<RejectedFeature> ListRejected() const;

 private:
  bool Agrees(const VisibleTag& seen) const;
  bool HasAdjacentStar(const BoardTag& tag) const;
  void StartAtNeighbour(const VisibleTag& seen, double min_correlation);
  bool Sweep(double min_correlation);
  bool TryWithCamera(const LatticeCamera& lens, double min_correlation);
  bool HasDirectNeighbour(int column, int row) const;
  bool IsAdjacentToTag(int column, int row) const;
  bool Predict(int column, int row, LocalMapping* mapping) const;
  bool PredictFromTag(int column, int row,
                      const std::vector<Correspondence>& around,
                      LocalMapping* mapping) const;
  MatchingResult Match(const SymmetryMask& mask, const LocalMapping& mapping,
                       double search_px);
  const GreyImage& GetDownscaledImage(int level);
  double CorrelationAround(int column, int row) const;
  bool IsOccupied(int column, int row, const Eigen::Vector2d& pixel,
                  const LocalMapping& mapping) const;
  bool IsFolded(int column, int row, const Eigen::Vector2d& pixel) const;

  const GreyImage& image_;
  const Board& board_;
  const StarTexture& texture_;
  const std::vector<SymmetryMask>& masks_;
  const DetectionOptions& options_;
  std::vector<VisibleTag> tags_;
  std::vector<GreyImage>
      downscaled_images_;  // each half the size of the previous one
  FeatureLattice lattice_;
  double min_correlation_ratio_ = 0;
  std::vector<double> correlations_;  // by feature
  // One per feature; -1: no attempt with the current minimum correlation
  std::vector<int> num_neighbors_at_last_attempt_;
  // By (row, column): predicted pixel and reason of the last failed attempt
  std::map<std::pair<int, int>, std::pair<Eigen::Vector2d, std::string>>
      last_attempts_;
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_STAR_STAR_GROWTH_H
