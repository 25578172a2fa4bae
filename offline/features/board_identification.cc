#include "features/board_identification.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "features/loose_lattice.h"
#include "features/star_growth.h"

namespace raygrid {
namespace {

// That a board of none of the tags looks so: seven cells, as far as the stars
// leave two placements.
constexpr double kMaxByChance = 1e-2;
// Of another placement, where there is doubt.
constexpr double kMaxRivalByChance = 5e-2;
// Of the stars, where the board has none: beside tags and along the edges half
// stars are seen.
constexpr double kMaxAstray = 0.2;
constexpr double kMaxWrongFrame = 0.1;
constexpr int kMinFrameCells = 4;   // of each colour
constexpr double kMinContrast = 8;  // grey levels

// (column, row) turned by quarters, clockwise on the board.
Eigen::Vector2d Turned(int quarter_turns, const Eigen::Vector2d& p) {
  switch (quarter_turns & 3) {
    case 0:
      return p;
    case 1:
      return {-p.y(), p.x()};
    case 2:
      return -p;
    default:
      return {p.y(), -p.x()};
  }
}

// What is seen of a tag's cells: grey levels, and what they must be.
struct SeenCells {
  std::vector<double> frame_black, frame_white;
  std::vector<double> code;
  std::vector<bool> code_is_black;
};

// The mappings around a lattice's places, made when first asked for.
class CellReader {
 public:
  CellReader(const GreyImage& image, const FeatureLattice& lattice, int reach,
             int degree)
      : image_(image), lattice_(lattice), reach_(reach), degree_(degree) {}

  // That a place on the lattice is seen there.
  void Add(const Eigen::Vector2d& place, const Eigen::Vector2d& pixel) {
    known_.push_back({place, pixel, 1});
    mappings_.clear();
  }

  // The mean grey level of a cell's inner half; nothing if it is not seen, or
  // if no stars tell where it is. Lengths in squares.
  std::optional<double> Read(const LatticePlacement& placement,
                             const Eigen::Vector2d& center, double cell) {
    const Eigen::Vector2d place = placement.OnLattice(center);
    const int column = static_cast<int>(std::lround(place.x()));
    const int row = static_cast<int>(std::lround(place.y()));
    const std::optional<LocalMapping>& mapping = MappingAt(column, row);
    if (!mapping) return std::nullopt;
    double sum = 0;
    for (const double v : {-0.25, 0.0, 0.25}) {
      for (const double u : {-0.25, 0.0, 0.25}) {
        const Eigen::Vector2d pixel = (*mapping)(
            placement.OnLattice(center + cell * Eigen::Vector2d(u, v)) -
            Eigen::Vector2d(column, row));
        if (!WholeImage(image_.size).Contains(pixel)) return std::nullopt;
        sum += image_.at(static_cast<int>(std::lround(pixel.x())),
                         static_cast<int>(std::lround(pixel.y())));
      }
    }
    return sum / 9;
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
  int reach_, degree_;
  std::vector<Correspondence> known_;  // offsets from the place (0, 0)
  std::map<std::pair<int, int>, std::optional<LocalMapping>> mappings_;
};

void ReadTag(const LatticePlacement& placement, const PlacedMarker& tag,
             double square_m, CellReader* reader, SeenCells* seen) {
  const double cell = tag.cell_m / square_m;
  const int last = tag.bits.size - 1;
  for (int row = 0; row <= last; ++row) {
    for (int column = 0; column <= last; ++column) {
      const auto level =
          reader->Read(placement,
                       tag.corner / square_m +
                           cell * Eigen::Vector2d(column + 0.5, row + 0.5),
                       cell);
      if (!level) continue;
      const int ring = std::min({row, column, last - row, last - column});
      if (ring == 0) {
        seen->frame_white.push_back(*level);
      } else if (ring == 1) {
        seen->frame_black.push_back(*level);
      } else {
        seen->code.push_back(*level);
        seen->code_is_black.push_back(tag.bits.at(column, row));
      }
    }
  }
}

double Mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / std::max<double>(1, values.size());
}

// The probability that at most num_wrong of count fair coins fall wrong.
double ByChance(int num_wrong, int count) {
  double term = std::pow(0.5, count), sum = 0;
  for (int k = 0; k <= num_wrong; ++k) {
    sum += term;
    term *= static_cast<double>(count - k) / (k + 1);
  }
  return std::min(1.0, sum);
}

// How likely the code's cells would agree as well by chance; 1 if what is seen
// is no tag.
double ChanceOf(const SeenCells& seen) {
  const int num_white = static_cast<int>(seen.frame_white.size());
  const int num_black = static_cast<int>(seen.frame_black.size());
  if (std::min(num_white, num_black) < kMinFrameCells) return 1;
  const double white = Mean(seen.frame_white), black = Mean(seen.frame_black);
  if (white - black < kMinContrast) return 1;
  const double threshold = (white + black) / 2;
  int num_wrong = 0;
  for (const double level : seen.frame_white) num_wrong += level < threshold;
  for (const double level : seen.frame_black) num_wrong += level > threshold;
  if (num_wrong > kMaxWrongFrame * (num_white + num_black)) return 1;
  num_wrong = 0;
  for (size_t i = 0; i < seen.code.size(); ++i)
    num_wrong += (seen.code[i] < threshold) != seen.code_is_black[i];
  return ByChance(num_wrong, static_cast<int>(seen.code.size()));
}

class Identification {
 public:
  Identification(const GreyImage& image, const FeatureLattice& lattice,
                 const std::vector<DetectedTag>& detected,
                 const std::vector<const TaggedBoard*>& boards)
      : detected_(detected), boards_(boards), stars_(lattice.Features()) {
    int tag_squares = 0;
    for (const TaggedBoard* board : boards)
      for (const BoardTag& tag : board->board.tags)
        tag_squares = std::max(tag_squares, tag.squares);
    // Beyond the stars a quadratic polynomial may predict better.
    for (const int degree : {3, 2})
      readers_.emplace_back(image, lattice, tag_squares / 2 + 3, degree);
  }

  std::optional<LatticePlacement> Run() {
    for (size_t b = 0; b < boards_.size(); ++b) {
      const int num_turns =
          QuarterTurnsThatKeepStars(boards_[b]->board.segments);
      for (int k = 0; k < num_turns; ++k)
        TryTurn(static_cast<int>(b), 4 / num_turns * k);
    }
    if (num_tags_seen_ == 0 || best_chance_ * num_tags_seen_ > kMaxByChance ||
        rival_chance_ < kMaxRivalByChance)
      return std::nullopt;
    return best_;
  }

 private:
  // All places of the lattice at which its stars are on the board.
  void TryTurn(int b, int quarter_turns) {
    const Board& board = boards_[b]->board;
    Eigen::Array2i low(1 << 20, 1 << 20), high = -low;
    LatticePlacement placement;
    placement.board = b;
    placement.quarter_turns = quarter_turns;
    for (const Feature& star : stars_) {
      const Eigen::Array2i p = placement.OnBoard(star.column, star.row).array();
      low = low.min(p);
      high = high.max(p);
    }
    for (int row = -low.y() - 1; row + high.y() <= board.rows; ++row) {
      for (int column = -low.x() - 1; column + high.x() <= board.columns;
           ++column) {
        placement.column = column;
        placement.row = row;
        if (Fits(placement)) Weigh(placement);
      }
    }
  }

  bool Fits(const LatticePlacement& placement) const {
    const Board& board = boards_[placement.board]->board;
    const int max_astray =
        std::max(1, static_cast<int>(kMaxAstray * stars_.size()));
    int num_astray = 0;
    for (const Feature& star : stars_) {
      const Eigen::Vector2i p = placement.OnBoard(star.column, star.row);
      const bool is_on_board = p.x() >= 0 && p.y() >= 0 &&
                               p.x() < board.columns && p.y() < board.rows;
      if ((!is_on_board || !board.HasFeature(p.x(), p.y())) &&
          ++num_astray > max_astray)
        return false;
    }
    return true;
  }

  // The corners of detected tags that the placement puts among stars that are
  // beside them in the image: they tell how the lattice goes on there.
  std::vector<Correspondence> CornersBesideStars(
      const LatticePlacement& placement) const {
    constexpr double kReachSquares = 3;
    std::vector<Correspondence> corners;
    for (const SeenTag& seen :
         SeenTagsOf(boards_[placement.board]->board, detected_)) {
      const auto& c = seen.corners;
      const Eigen::Vector2d middle = (c[0] + c[1] + c[2] + c[3]) / 4;
      const Feature& star = *std::min_element(
          stars_.begin(), stars_.end(),
          [&](const Feature& s, const Feature& t) {
            return (s.pixel - middle).norm() < (t.pixel - middle).norm();
          });
      const auto on_board = CornersOnBoard(seen.tag);
      const Eigen::Vector2d offset =
          (on_board[0] + on_board[2]) / 2 -
          placement.OnBoard(star.column, star.row).cast<double>();
      if (offset.cwiseAbs().maxCoeff() > seen.tag.squares / 2.0 + kReachSquares)
        continue;
      for (int k = 0; k < 4; ++k)
        corners.push_back({placement.OnLattice(on_board[k]), c[k]});
    }
    return corners;
  }

  double ChanceWith(const LatticePlacement& placement,
                    CellReader* reader) const {
    const TaggedBoard& tagged = *boards_[placement.board];
    SeenCells seen;
    for (const PlacedMarker& tag : tagged.tags)
      ReadTag(placement, tag, tagged.board.square_m, reader, &seen);
    return ChanceOf(seen);
  }

  void Weigh(const LatticePlacement& placement) {
    const auto corners = CornersBesideStars(placement);
    double chance = 1;
    for (CellReader& reader : readers_) {
      chance = std::min(chance, ChanceWith(placement, &reader));
      if (corners.empty()) continue;
      CellReader with_corners = reader;
      for (const Correspondence& corner : corners)
        with_corners.Add(corner.offset, corner.pixel);
      chance = std::min(chance, ChanceWith(placement, &with_corners));
    }
    num_tags_seen_ += chance < 1;
    if (chance < best_chance_) {
      rival_chance_ = best_chance_;
      best_chance_ = chance;
      best_ = placement;
    } else {
      rival_chance_ = std::min(rival_chance_, chance);
    }
  }

  const std::vector<DetectedTag>& detected_;
  const std::vector<const TaggedBoard*>& boards_;
  std::vector<CellReader> readers_;
  std::vector<Feature> stars_;
  LatticePlacement best_;
  double best_chance_ = 1, rival_chance_ = 1;
  int num_tags_seen_ = 0;
};

}  // namespace

Eigen::Vector2i LatticePlacement::OnBoard(int lattice_column,
                                          int lattice_row) const {
  const Eigen::Vector2d turned =
      Turned(quarter_turns, Eigen::Vector2d(lattice_column, lattice_row));
  return turned.array().round().cast<int>().matrix() +
         Eigen::Vector2i(column, row);
}

Eigen::Vector2d LatticePlacement::OnLattice(
    const Eigen::Vector2d& on_board) const {
  return Turned(4 - quarter_turns, on_board - Eigen::Vector2d(column, row));
}

std::optional<LatticePlacement> IdentifyBoard(
    const GreyImage& image, const FeatureLattice& lattice,
    const std::vector<DetectedTag>& detected,
    const std::vector<const TaggedBoard*>& boards) {
  if (lattice.num_found() == 0) return std::nullopt;
  return Identification(image, lattice, detected, boards).Run();
}

}  // namespace raygrid
