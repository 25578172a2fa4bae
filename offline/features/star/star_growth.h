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
#include "features/board_view/lattice_lens.h"
#include "features/board_view/tag_detection.h"
#include "features/refinement/matching_refinement.h"
#include "features/refinement/symmetry_mask.h"

namespace raygrid {

/// The fewest stars on a board that is believed.
constexpr int kMinStarsOnBoard = 5;

/// A tag of a board, seen in the image.
struct VisibleTag {
  BoardTag tag;
  std::array<Eigen::Vector2d, 4> corners;
  Eigen::Matrix3d homography;  ///< from squares to pixels
};

/// The corners of a tag's black square, clockwise from the top left, in
/// squares.
std::array<Eigen::Vector2d, 4> CornersOnBoard(const BoardTag& tag);

/// The tags of a board among those detected.
std::vector<VisibleTag> FindVisibleTags(
    const Board& board, const std::vector<DetectedTag>& detected);

/// Finds the stars of one board, each beside one that is found.
class StarGrowth {
 public:
  /// Keeps references. One mask for each feature of the board, or one for all.
  StarGrowth(const GreyImage& image, const Board& board,
             const StarTexture& texture, const std::vector<SymmetryMask>& masks,
             const DetectionOptions& options, std::vector<VisibleTag> tags);

  /// A star that is known.
  void Set(int column, int row, const Eigen::Vector2d& pixel) {
    lattice_.Set(column, row, pixel);
  }
  /// Stars must correlate with their rendering at least this part as much as
  /// their neighbours do.
  void RequireAlike(double part) { alike_ = part; }
  /// Looks for a star within a part of a square around where it would be;
  /// whether it is found.
  bool Try(int column, int row, const LocalMapping& mapping,
           double search_squares, double min_correlation);
  /// Looks around the tags, then beside each star, until there are no more.
  void Grow();
  /// Looks where the lens that explains what is found shows stars that nothing
  /// found is beside, as behind a tag at the image's edge; and beside those.
  void GrowAcrossGaps();

  /// Whether the stars around each tag are where its corners say.
  bool AgreesWithTags() const;
  /// Whether there are enough stars, and for each at most so many places where
  /// one was sought in vain.
  bool IsSound(double max_in_vain) const;

  const FeatureLattice& lattice() const { return lattice_; }
  /// The places where stars were sought in vain, and why.
  std::vector<RejectedFeature> Rejected() const;

 private:
  bool Agrees(const VisibleTag& seen) const;
  bool HasAdjacentStar(const BoardTag& tag) const;
  void StartAtNeighbour(const VisibleTag& seen, double min_correlation);
  bool Sweep(double min_correlation);
  bool TryByLens(const LatticeLens& lens, double min_correlation);
  bool HasDirectNeighbour(int column, int row) const;
  bool IsAdjacentToTag(int column, int row) const;
  bool Predict(int column, int row, LocalMapping* mapping) const;
  bool PredictFromTag(int column, int row,
                      const std::vector<Correspondence>& around,
                      LocalMapping* mapping) const;
  MatchingResult Match(const SymmetryMask& mask, const LocalMapping& mapping,
                       double search_px);
  const GreyImage& Smaller(int level);
  double CorrelationAround(int column, int row) const;
  bool IsOccupied(int column, int row, const Eigen::Vector2d& pixel,
                  const LocalMapping& mapping) const;
  bool TurnsBack(int column, int row, const Eigen::Vector2d& pixel) const;

  const GreyImage& image_;
  const Board& board_;
  const StarTexture& texture_;
  const std::vector<SymmetryMask>& masks_;
  const DetectionOptions& options_;
  std::vector<VisibleTag> tags_;
  std::vector<GreyImage> smaller_;  // each half as large as the one before
  FeatureLattice lattice_;
  double alike_ = 0;
  std::vector<double> correlations_;  // by place
  std::vector<int> tried_with_;       // how many neighbours, by place; or -1
  // The attempts by row and column: where a star was sought in vain, and why.
  std::map<std::pair<int, int>, std::pair<Eigen::Vector2d, std::string>>
      attempts_;
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_STAR_STAR_GROWTH_H
