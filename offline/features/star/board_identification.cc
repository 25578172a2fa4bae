#include "features/star/board_identification.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "features/board_view/lattice_camera.h"
#include "features/star/star_growth.h"

namespace raygrid {
namespace {

// Maximum probability that the visible tag cells match by chance: 9 cells, if
// the stars are consistent with a single placement.
constexpr double kMaxFalseAlarmProbability = 2e-3;
// Another placement makes the identification ambiguous if its probability of
// matching by chance is below kMaxRivalProbability and below kRivalOverBest
// times that of the best placement.
constexpr double kMaxRivalProbability = 5e-2;
constexpr double kRivalOverBest = 1e4;
constexpr double kMaxWrongFrame = 0.1;
constexpr int kMinFrameCells = 4;   // per colour
constexpr double kMinContrast = 8;  // grey levels

// A cell of a tag in board coordinates, in squares.
struct Cell {
  Eigen::Vector2d center;
  double side;
  bool is_black;
};

// The cells of all tags of a board. frames: white margins and black borders.
struct Cells {
  std::vector<Cell> frames, codes;
};

Cells MakeCells(const TaggedBoard& tagged) {
  Cells cells;
  const double square_m = tagged.board.square_m;
  for (const PlacedMarker& tag : tagged.tags) {
    const double side = tag.cell_m / square_m;
    const int last = tag.bits.size - 1;
    for (int row = 0; row <= last; ++row) {
      for (int column = 0; column <= last; ++column) {
        const Cell cell = {tag.corner / square_m +
                               side * Eigen::Vector2d(column + 0.5, row + 0.5),
                           side, tag.bits.at(column, row)};
        const int ring = std::min({row, column, last - row, last - column});
        (ring < 2 ? cells.frames : cells.codes).push_back(cell);
      }
    }
  }
  return cells;
}

// Reads the mean grey levels of tag cells. Cells are projected by local
// mappings, which are fitted to the stars around lattice positions on first use
// and cached, or by a lens model fitted to the whole lattice.
class CellReader {
 public:
  CellReader(const GreyImage& image, const FeatureLattice& lattice, int reach,
             int degree)
      : image_(image), lattice_(lattice), reach_(reach), degree_(degree) {}
  CellReader(const GreyImage& image, const FeatureLattice& lattice,
             const LatticeCamera& lens)
      : image_(image), lattice_(lattice), lens_(lens) {}

  bool has_camera() const { return lens_.has_value(); }

  // Adds a correspondence between a lattice position and a pixel.
  void Add(const Eigen::Vector2d& place, const Eigen::Vector2d& pixel) {
    known_.push_back({place, pixel, 1});
    mappings_.clear();
  }

  // Returns the mean grey level of the inner half of a cell; nullopt if most of
  // it is outside the image, or if there are too few stars nearby for a local
  // mapping.
  std::optional<double> Read(const LatticePlacement& placement,
                             const Cell& cell) {
    const Eigen::Vector2d center = placement.OnLattice(cell.center);
    const int column = static_cast<int>(std::lround(center.x()));
    const int row = static_cast<int>(std::lround(center.y()));
    const LocalMapping* mapping = nullptr;
    if (!lens_) {
      const std::optional<LocalMapping>& known = MappingAt(column, row);
      if (!known) return std::nullopt;
      mapping = &*known;
    }
    const auto seen_at =
        [&](const Eigen::Vector2d& place) -> std::optional<Eigen::Vector2d> {
      if (lens_) return lens_->Project(place);
      return (*mapping)(place - Eigen::Vector2d(column, row));
    };
    constexpr int kMinSamples = 6;  // out of nine
    double sum = 0;
    int count = 0;
    for (const double v : {-0.25, 0.0, 0.25}) {
      for (const double u : {-0.25, 0.0, 0.25}) {
        const auto pixel = seen_at(center + cell.side * Eigen::Vector2d(u, v));
        if (!pixel || !WholeImage(image_.size).Contains(*pixel)) continue;
        sum += image_.at(static_cast<int>(std::lround(pixel->x())),
                         static_cast<int>(std::lround(pixel->y())));
        ++count;
      }
    }
    if (count < kMinSamples) return std::nullopt;
    return sum / count;
  }

 private:
  const std::optional<LocalMapping>& MappingAt(int column, int row) {
    const auto made_before = mappings_.find({column, row});
    if (made_before != mappings_.end()) return made_before->second;
    std::optional<LocalMapping>& made = mappings_[{column, row}];
    if (!lattice_.IsOnBoard(column, row)) return made;
    std::vector<Correspondence> around =
        lattice_.Around(column, row, reach_, true);
    for (const Correspondence& known : known_) {
      const Eigen::Vector2d offset =
          known.offset - Eigen::Vector2d(column, row);
      around.push_back(
          {offset, known.pixel, 1 / (1 + 0.5 * offset.squaredNorm())});
    }
    LocalMapping mapping;
    if (FitLocalMapping(around, degree_, &mapping) > 0) made = mapping;
    return made;
  }

  const GreyImage& image_;
  const FeatureLattice& lattice_;
  int reach_ = 0, degree_ = 0;
  std::optional<LatticeCamera> lens_;
  std::vector<Correspondence> known_;  // offsets from lattice (0, 0)
  std::map<std::pair<int, int>, std::optional<LocalMapping>> mappings_;
};

// Returns P(k <= num_wrong) for k ~ Binomial(count, 1/2): the probability that
// random cells match as well.
double ComputeBinomialTail(int num_wrong, int count) {
  double term = std::pow(0.5, count), sum = 0;
  for (int k = 0; k <= num_wrong; ++k) {
    sum += term;
    term *= static_cast<double>(count - k) / (k + 1);
  }
  return std::min(1.0, sum);
}

// A cell with its grey level, and its distance from the nearest star in
// squares.
struct SampledCell {
  double distance, level;
  bool is_black;
};

// The frame of a visible tag: grey-level threshold, and the maximum distance
// from the stars (in squares) up to which the colours of its cells are as
// expected. Farther cells are not used: their predicted positions are
// inaccurate, or the image's edge hides them.
struct DetectedFrame {
  double threshold = 0;  // between black and white cells
  double max_distance = -1;
};

DetectedFrame FitFrame(std::vector<SampledCell> cells, bool is_whole) {
  std::stable_sort(cells.begin(), cells.end(),
                   [](const SampledCell& a, const SampledCell& b) {
                     return a.distance < b.distance;
                   });
  DetectedFrame frame;
  for (size_t count = cells.size(); count >= 2 * kMinFrameCells; --count) {
    double sums[2] = {0, 0};  // white, black
    int counts[2] = {0, 0};
    for (size_t i = 0; i < count; ++i) {
      sums[cells[i].is_black] += cells[i].level;
      ++counts[cells[i].is_black];
    }
    if (std::min(counts[0], counts[1]) < kMinFrameCells) break;
    const double white = sums[0] / counts[0], black = sums[1] / counts[1];
    if (white - black < kMinContrast) {
      if (is_whole) break;
      continue;
    }
    const double threshold = (white + black) / 2;
    int num_wrong = 0;
    for (size_t i = 0; i < count; ++i)
      num_wrong += (cells[i].level < threshold) != cells[i].is_black;
    if (num_wrong > kMaxWrongFrame * static_cast<double>(count)) {
      if (is_whole) break;
      continue;
    }
    frame.threshold = threshold;
    frame.max_distance = count == cells.size()
                             ? std::numeric_limits<double>::infinity()
                             : cells[count - 1].distance;
    break;
  }
  return frame;
}

// Removes stars that are not consistent with the lens model: past the edge of a
// strongly foreshortened board, the lattice may have been extended by
// structures that resemble half stars, whose spacing differs from the
// prediction.
void RemoveUnexplained(const LatticeCamera& lens, std::vector<Feature>* stars) {
  constexpr double kMaxErrorSquares = 0.15;
  stars->erase(
      std::remove_if(stars->begin(), stars->end(),
                     [&](const Feature& star) {
                       const auto seen =
                           lens.Around(Eigen::Vector2d(star.column, star.row));
                       return !seen || (seen->center - star.pixel).norm() >
                                           kMaxErrorSquares * seen->SpacingPx();
                     }),
      stars->end());
}

class Identification {
 public:
  Identification(const GreyImage& image, const FeatureLattice& lattice,
                 const std::vector<DetectedTag>& detected,
                 const std::vector<const TaggedBoard*>& boards)
      : detected_(detected), boards_(boards), stars_(lattice.Features()) {
    int tag_squares = 0;
    for (const TaggedBoard* board : boards) {
      cells_.push_back(MakeCells(*board));
      for (const BoardTag& tag : board->board.tags)
        tag_squares = std::max(tag_squares, tag.squares);
    }
    // Quadratic polynomials may extrapolate better than cubic ones.
    for (const int degree : {3, 2})
      readers_.emplace_back(image, lattice, tag_squares / 2 + 3, degree);
    if (const auto lens = LatticeCamera::Fit(stars_, image.size)) {
      readers_.emplace_back(image, lattice, *lens);
      RemoveUnexplained(*lens, &stars_);
    }
  }

  std::optional<LatticePlacement> Run() {
    for (size_t b = 0; b < boards_.size(); ++b) {
      for (LatticePlacement placement :
           ListPlacements(stars_, boards_[b]->board)) {
        placement.board = static_cast<int>(b);
        Weigh(placement);
      }
    }
    if (num_detected_tags_ == 0 ||
        best_probability_ * num_detected_tags_ > kMaxFalseAlarmProbability ||
        rival_probability_ <
            std::min(kMaxRivalProbability, kRivalOverBest * best_probability_))
      return std::nullopt;
    return best_;
  }

 private:
  // Returns the corners of detected tags that, in this placement, are adjacent
  // to stars that are also near the tag in the image; they improve the local
  // mappings.
  std::vector<Correspondence> CollectCornersNearStars(
      const LatticePlacement& placement) const {
    constexpr double kRadiusSquares = 3;
    std::vector<Correspondence> corners;
    for (const VisibleTag& seen :
         FindVisibleTags(boards_[placement.board]->board, detected_)) {
      const auto& c = seen.corners;
      const Eigen::Vector2d midpoint = (c[0] + c[1] + c[2] + c[3]) / 4;
      const Feature& star = *std::min_element(
          stars_.begin(), stars_.end(),
          [&](const Feature& s, const Feature& t) {
            return (s.pixel - midpoint).norm() < (t.pixel - midpoint).norm();
          });
      const auto on_board = CornersOnBoard(seen.tag);
      const Eigen::Vector2d offset =
          (on_board[0] + on_board[2]) / 2 -
          placement.OnBoard(star.column, star.row).cast<double>();
      if (offset.cwiseAbs().maxCoeff() >
          seen.tag.squares / 2.0 + kRadiusSquares)
        continue;
      for (int k = 0; k < 4; ++k)
        corners.push_back({placement.OnLattice(on_board[k]), c[k]});
    }
    return corners;
  }

  std::vector<SampledCell> Read(const LatticePlacement& placement,
                                const std::vector<Cell>& cells,
                                CellReader* reader) const {
    std::vector<SampledCell> seen;
    for (const Cell& cell : cells) {
      const auto level = reader->Read(placement, cell);
      if (!level) continue;
      const Eigen::Vector2d place = placement.OnLattice(cell.center);
      double min_squared_distance = 1e9;
      for (const Feature& star : stars_)
        min_squared_distance = std::min(
            min_squared_distance,
            (place - Eigen::Vector2d(star.column, star.row)).squaredNorm());
      seen.push_back({std::sqrt(min_squared_distance), *level, cell.is_black});
    }
    return seen;
  }

  // Returns the probability that the code cells match as well by chance; 1 if
  // no tag frame is found. has_corners: the tag's corners are known, so the
  // complete frame must match.
  double ComputeFalseAlarmProbability(const LatticePlacement& placement,
                                      bool has_corners,
                                      CellReader* reader) const {
    const Cells& cells = cells_[placement.board];
    const DetectedFrame frame =
        FitFrame(Read(placement, cells.frames, reader), has_corners);
    if (frame.max_distance < 0) return 1;
    int count = 0, num_wrong = 0;
    for (const SampledCell& cell : Read(placement, cells.codes, reader)) {
      if (cell.distance > frame.max_distance) continue;
      ++count;
      num_wrong += (cell.level < frame.threshold) != cell.is_black;
    }
    return ComputeBinomialTail(num_wrong, count);
  }

  void Weigh(const LatticePlacement& placement) {
    const auto corners = CollectCornersNearStars(placement);
    double chance = 1;
    for (CellReader& reader : readers_) {
      chance = std::min(
          chance, ComputeFalseAlarmProbability(placement, false, &reader));
      if (corners.empty() || reader.has_camera()) continue;
      CellReader with_corners = reader;
      for (const Correspondence& corner : corners)
        with_corners.Add(corner.offset, corner.pixel);
      chance = std::min(
          chance, ComputeFalseAlarmProbability(placement, true, &with_corners));
    }
    num_detected_tags_ += chance < 1;
    if (chance < best_probability_) {
      rival_probability_ = best_probability_;
      best_probability_ = chance;
      best_ = placement;
    } else {
      rival_probability_ = std::min(rival_probability_, chance);
    }
  }

  const std::vector<DetectedTag>& detected_;
  const std::vector<const TaggedBoard*>& boards_;
  std::vector<Cells> cells_;  // one per board
  std::vector<CellReader> readers_;
  std::vector<Feature> stars_;
  LatticePlacement best_;
  double best_probability_ = 1, rival_probability_ = 1;
  int num_detected_tags_ = 0;
};

}  // namespace

std::optional<LatticePlacement> IdentifyBoard(
    const GreyImage& image, const FeatureLattice& lattice,
    const std::vector<DetectedTag>& detected,
    const std::vector<const TaggedBoard*>& boards) {
  if (lattice.num_found() == 0) return std::nullopt;
  return Identification(image, lattice, detected, boards).Run();
}

}  // namespace raygrid
