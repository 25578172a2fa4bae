#include "features/star/star_detection.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include "features/board_view/locators.h"
#include "features/board_view/tag_detection.h"
#include "features/refinement/feature_refinement.h"
#include "features/star/board_identification.h"
#include "features/star/board_layout.h"
#include "features/star/loose_lattice.h"
#include "features/star/star_growth.h"

namespace raygrid {
namespace {

// Minimum number of star candidates for which a board is searched.
constexpr size_t kMinCandidates = 8;
constexpr int kMaxLooseLattices = 3;
// Maximum numbers of unsuccessful searches per detected star: above
// kMaxFailuresPerStar a lattice is rejected; above kMaxFailuresPerStarIfFound
// it may have been extended wrongly near the image's edge, and the search for
// its board continues.
constexpr double kMaxFailuresPerStar = 0.25, kMaxFailuresPerStarIfFound = 0.05;

struct StarBoard {
  StarBoard(const Board& board, const DetectionOptions& options)
      : tagged(board), texture(board.segments), refiner(board, options) {}

  const Board& board() const { return tagged.board; }

  TaggedBoard tagged;
  StarTexture texture;
  FeatureRefiner refiner;
};

using StarBoardList = std::vector<std::unique_ptr<StarBoard>>;
using LooseFinders = std::map<int, std::unique_ptr<LooseLatticeFinder>>;

bool IsOnABoard(const DetectedTag& tag, const StarBoardList& boards) {
  return std::any_of(boards.begin(), boards.end(), [&](const auto& star) {
    return !FindVisibleTags(star->board(), {tag}).empty();
  });
}

// Searches the boards in one image with methods of increasing cost.
class Search {
 public:
  Search(const GreyImage& image, const StarBoardList& boards,
         const LooseFinders& finders, const DetectionOptions& options)
      : image_(image),
        boards_(boards),
        finders_(finders),
        options_(options),
        growths_(boards.size()) {}

  void Run() {
    GrowFromTags(DetectTags(image_, TagSearch::kQuick));
    if (IsComplete()) return;
    SearchLooseLattices(image_, 1);
    const bool may_have_other_stars = HasUnexplainedCandidates();
    SearchSmallerImages();
    if (may_have_other_stars && !IsComplete() &&
        !IsQuickSearchThorough(image_.size))
      GrowFromTags(DetectTags(image_, TagSearch::kThorough));
  }

  const std::vector<DetectedTag>& tags() const { return tags_; }
  // Returns nullptr if the board was not detected.
  const StarGrowth* growth(size_t board) const { return growths_[board].get(); }
  // Whether there are stars whose board could not be identified.
  bool has_unidentified_stars() const { return has_unidentified_stars_; }

 private:
  bool IsFound(size_t board) const {
    return growths_[board] &&
           growths_[board]->HasFewFailures(kMaxFailuresPerStarIfFound);
  }
  bool IsBoardDetected(size_t board) const {
    return growths_[board] &&
           growths_[board]->HasFewFailures(kMaxFailuresPerStar);
  }
  bool AreAllBoardsDetected() const {
    for (size_t b = 0; b < boards_.size(); ++b)
      if (!IsBoardDetected(b)) return false;
    return true;
  }
  bool IsComplete() const {
    for (size_t b = 0; b < boards_.size(); ++b)
      if (!IsFound(b)) return false;
    return true;
  }
  // Whether boards are missing and enough star candidates remain.
  bool HasUnexplainedCandidates() const {
    return !IsComplete() && candidates_.size() >= kMinCandidates;
  }
  bool HasUnknownTag() const {
    return std::any_of(tags_.begin(), tags_.end(), [&](const auto& tag) {
      return !IsOnABoard(tag, boards_);
    });
  }
  // Keeps the growth with more stars for a board.
  void Put(size_t board, std::unique_ptr<StarGrowth> growth) {
    if (!growths_[board] ||
        growth->lattice().num_found() > growths_[board]->lattice().num_found())
      growths_[board] = std::move(growth);
  }

  std::unique_ptr<StarGrowth> MakeGrowth(size_t b,
                                         std::vector<VisibleTag> tags) const {
    return std::make_unique<StarGrowth>(
        image_, boards_[b]->board(), boards_[b]->texture,
        boards_[b]->refiner.masks(), options_, std::move(tags));
  }

  void GrowFromTags(std::vector<DetectedTag> tags) {
    tags_ = std::move(tags);
    for (size_t b = 0; b < boards_.size(); ++b) {
      if (IsFound(b)) continue;
      std::vector<VisibleTag> seen =
          FindVisibleTags(boards_[b]->board(), tags_);
      if (seen.empty()) continue;
      GrowFrom(b, seen);
      // Tags near the image's edge may be inaccurate: tries each tag
      // separately.
      for (size_t k = 0; seen.size() > 1 && k < seen.size() && !IsFound(b); ++k)
        GrowFrom(b, {seen[k]});
    }
  }

  void GrowFrom(size_t b, std::vector<VisibleTag> tags) {
    auto growth = MakeGrowth(b, std::move(tags));
    growth->Grow();
    growth->GrowAcrossGaps();
    if (growth->AgreesWithTags()) Put(b, std::move(growth));
  }

  // Searches lattices of unidentified boards in an image downscaled by `scale`.
  void SearchLooseLattices(const GreyImage& smaller, double scale) {
    candidates_ = FindStarCandidates(smaller);
    for (StarCandidate& candidate : candidates_)
      candidate.pixel = FromDownscaled(candidate.pixel, scale);
    for (size_t b = 0; b < boards_.size(); ++b)
      if (IsFound(b))
        RemoveUsedCandidates(growths_[b]->lattice(), &candidates_);
    for (const auto& [segments, finder] : finders_)
      GrowFromLooseLattices(segments, *finder, smaller, scale);
  }

  // Large stars are searched in downscaled images, because their interiors
  // contain many structures that resemble small stars.
  void SearchSmallerImages() {
    constexpr double kMinScale = 4;
    GreyImage smaller = image_;
    for (double scale = 2; scale <= kMinScale && !AreAllBoardsDetected();
         scale *= 2) {
      smaller = HalveImage(smaller);
      SearchLooseLattices(smaller, scale);
    }
  }

  void GrowFromLooseLattices(int segments, const LooseLatticeFinder& finder,
                             const GreyImage& smaller, double scale) {
    for (int k = 0; k < kMaxLooseLattices; ++k) {
      std::vector<size_t> missing;
      std::vector<const TaggedBoard*> tagged;
      for (size_t b = 0; b < boards_.size(); ++b) {
        if (boards_[b]->board().segments != segments || IsFound(b)) continue;
        missing.push_back(b);
        tagged.push_back(&boards_[b]->tagged);
      }
      if (missing.empty() || !HasUnexplainedCandidates()) return;
      const auto lattices = finder.Find(image_, smaller, scale, &candidates_);
      if (lattices.empty()) return;
      has_unidentified_stars_ |=
          !GrowFromFirstIdentified(lattices, missing, tagged);
    }
  }

  // Grows from the first identifiable lattice; returns false if there is none.
  // The lattices are alternatives for the same stars.
  bool GrowFromFirstIdentified(const std::vector<FeatureLattice>& lattices,
                               const std::vector<size_t>& missing,
                               const std::vector<const TaggedBoard*>& tagged) {
    // The layout of a chessboard does not distinguish its lattice from the
    // shifted ones.
    const bool is_chessboard = tagged[0]->board.segments == 4;
    for (const FeatureLattice& lattice : lattices) {
      auto placement = IdentifyBoard(image_, lattice, tags_, tagged);
      if (!placement && !is_chessboard)
        placement = AssignRemainingBoard(lattice, missing);
      if (!placement) continue;
      GrowFromLattice(missing[placement->board], lattice, *placement);
      return true;
    }
    return false;
  }

  // If exactly one board of this kind is missing and all others are detected,
  // the lattice must belong to it, even if none of its tags is visible.
  std::optional<LatticePlacement> AssignRemainingBoard(
      const FeatureLattice& lattice, const std::vector<size_t>& missing) const {
    const auto is_left = [&](size_t b) { return !IsBoardDetected(b); };
    const auto left = std::find_if(missing.begin(), missing.end(), is_left);
    if (left == missing.end() ||
        std::find_if(left + 1, missing.end(), is_left) != missing.end() ||
        HasUnknownTag())
      return std::nullopt;
    std::vector<Feature> others;
    for (size_t b = 0; b < boards_.size(); ++b) {
      if (!IsBoardDetected(b)) continue;
      const std::vector<Feature> found = growths_[b]->lattice().Features();
      others.insert(others.end(), found.begin(), found.end());
    }
    if (others.empty()) return std::nullopt;
    const Board& board = boards_[*left]->board();
    auto placement = AssignWithLayout(image_, lattice, board);
    if (!placement || AreOnBoard(others, lattice, *placement, board))
      return std::nullopt;
    placement->board = static_cast<int>(left - missing.begin());
    return placement;
  }

  void GrowFromLattice(size_t b, const FeatureLattice& lattice,
                       const LatticePlacement& placement) {
    const Board& board = boards_[b]->board();
    auto growth = MakeGrowth(b, {});
    for (const Feature& star : lattice.Features()) {
      const Eigen::Vector2i place = placement.OnBoard(star.column, star.row);
      if (growth->lattice().IsOnBoard(place.x(), place.y()) &&
          board.HasFeature(place.x(), place.y()))
        growth->Set(place.x(), place.y(), star.pixel);
    }
    growth->Grow();
    growth->GrowAcrossGaps();
    RemoveUsedCandidates(growth->lattice(), &candidates_);
    Put(b, std::move(growth));
  }

  const GreyImage& image_;
  const StarBoardList& boards_;
  const LooseFinders& finders_;
  const DetectionOptions& options_;
  std::vector<DetectedTag> tags_;
  std::vector<std::unique_ptr<StarGrowth>> growths_;  // one per board
  std::vector<StarCandidate> candidates_;
  bool has_unidentified_stars_ = false;
};

void Append(const std::vector<RejectedFeature>& from,
            std::vector<RejectedFeature>* to) {
  to->insert(to->end(), from.begin(), from.end());
}

}  // namespace

struct StarDetector::Data {
  StarBoardList boards;
  LooseFinders loose_finders;  // key: number of segments
  DetectionOptions options;

  void Refine(const GreyImage& image, const StarBoard& star,
              const StarGrowth& growth, ImageDetection* detection) const;
  std::vector<std::string> UnknownTags(
      const std::vector<DetectedTag>& tags) const;
};

void StarDetector::Data::Refine(const GreyImage& image, const StarBoard& star,
                                const StarGrowth& growth,
                                ImageDetection* detection) const {
  ImageDetection found =
      star.refiner.Refine(image, growth.lattice().Features());
  Append(growth.ListRejected(), &detection->rejected);
  Append(found.rejected, &detection->rejected);
  if (found.features.size() < kMinStarsOnBoard) {
    detection->warnings.push_back(
        fmt::format("board {}: its tag was detected, but fewer than {} stars",
                    star.board().id, kMinStarsOnBoard));
    return;
  }
  detection->features.insert(detection->features.end(), found.features.begin(),
                             found.features.end());
}

std::vector<std::string> StarDetector::Data::UnknownTags(
    const std::vector<DetectedTag>& tags) const {
  std::vector<std::string> unknown;
  for (const DetectedTag& tag : tags)
    if (!IsOnABoard(tag, boards))
      unknown.push_back(fmt::format("tag {} is not in the pattern", tag.id));
  return unknown;
}

StarDetector::StarDetector(const Pattern& pattern,
                           const DetectionOptions& options)
    : data_(new Data) {
  data_->options = options;
  std::map<int, int> max_sides;
  for (const Board& board : pattern.boards) {
    if (board.segments == 0) continue;
    data_->boards.push_back(std::make_unique<StarBoard>(board, options));
    int& max_side = max_sides[board.segments];
    max_side = std::max({max_side, board.columns, board.rows});
  }
  for (const auto& [segments, max_side] : max_sides)
    data_->loose_finders[segments] =
        std::make_unique<LooseLatticeFinder>(segments, max_side, options);
}
StarDetector::~StarDetector() = default;

ImageDetection StarDetector::Detect(const GreyImage& image) const {
  Search search(image, data_->boards, data_->loose_finders, data_->options);
  search.Run();
  ImageDetection detection;
  for (size_t b = 0; b < data_->boards.size(); ++b)
    if (search.growth(b))
      data_->Refine(image, *data_->boards[b], *search.growth(b), &detection);
  for (const std::string& warning : data_->UnknownTags(search.tags()))
    detection.warnings.push_back(warning);
  if (search.tags().empty() && detection.features.empty())
    for (const std::string& seen : DescribeOtherTags(image))
      detection.warnings.push_back("no tag of the pattern found, but " + seen);
  if (search.has_unidentified_stars() && detection.features.empty() &&
      detection.warnings.empty())
    detection.warnings.push_back(
        "stars detected, but no tag to identify the board");
  return detection;
}

Locator MakeStarLocator(const Board&) { return {}; }

}  // namespace raygrid
