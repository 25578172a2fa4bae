#include "initialization/dense_matches.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace raygrid {
namespace {

constexpr int kPixelsAlong = 160;
constexpr int kMaxWidth = 3;  // side of a lattice square, in board squares

// Corners of a square in cyclic order, in the image or on the board.
using Corners = std::array<Eigen::Vector2d, 4>;

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Whether the quadrilateral is convex and not mirrored.
bool IsPlausibleSquare(const Corners& corners) {
  for (int k = 0; k < 4; ++k)
    if (!(Cross(corners[(k + 1) % 4] - corners[k],
                corners[(k + 2) % 4] - corners[(k + 1) % 4]) > 0))
      return false;
  return true;
}

bool Contains(const Corners& corners, const Eigen::Vector2d& pixel) {
  for (int k = 0; k < 4; ++k)
    if (Cross(corners[(k + 1) % 4] - corners[k], pixel - corners[k]) < 0)
      return false;
  return true;
}

// Projective basis that maps the unit vectors to the first three corners, and
// their sum to the fourth one.
Eigen::Matrix3d ProjectiveBasis(const Corners& corners) {
  Eigen::Matrix3d basis;
  for (int k = 0; k < 3; ++k) basis.col(k) = corners[k].homogeneous();
  const Eigen::Vector3d lengths = basis.inverse() * corners[3].homogeneous();
  return basis * lengths.asDiagonal();
}

// Features of a view, indexed by column and row.
class ViewFeatures {
 public:
  ViewFeatures(const Board& board, const ImageFeatures& image)
      : board_(board), nominal_(board.NominalPoints()) {
    pixels_.resize(board.num_points());
    for (const Feature& feature : image.features)
      if (feature.board == board.id)
        pixels_[board.PointIndex(feature.column, feature.row)] = feature.pixel;
  }

  // Finds the corners of the square with the given width and position; returns
  // false unless all of its features were detected.
  bool FindSquare(int column, int row, int width, Corners* pixels,
                  Corners* points) const {
    const int dx[4] = {0, width, width, 0}, dy[4] = {0, 0, width, width};
    for (int k = 0; k < 4; ++k) {
      const int index = board_.PointIndex(column + dx[k], row + dy[k]);
      if (!pixels_[index]) return false;
      (*pixels)[k] = *pixels_[index];
      (*points)[k] = nominal_[index].head<2>();
    }
    return true;
  }

 private:
  const Board& board_;
  std::vector<Eigen::Vector3d> nominal_;
  std::vector<std::optional<Eigen::Vector2d>> pixels_;
};

using PointsByPixel = std::vector<std::optional<Eigen::Vector2d>>;

// Sets the points of the lattice pixels inside a square that do not have one
// yet.
void FillSquare(const Corners& pixels, const Corners& points,
                const PixelLattice& lattice, PointsByPixel* filled) {
  Eigen::Vector2d low = pixels[0], high = pixels[0];
  for (const Eigen::Vector2d& corner : pixels) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  const double step = lattice.step_px;
  const int x0 = std::max(0, static_cast<int>(std::ceil(low.x() / step)));
  const int y0 = std::max(0, static_cast<int>(std::ceil(low.y() / step)));
  const int x1 =
      std::min(lattice.columns - 1, static_cast<int>(high.x() / step));
  const int y1 = std::min(lattice.rows - 1, static_cast<int>(high.y() / step));
  const Eigen::Matrix3d board_from_image =
      ProjectiveBasis(points) * ProjectiveBasis(pixels).inverse();
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const int index = y * lattice.columns + x;
      const Eigen::Vector2d pixel = lattice.Pixel(index);
      if (!(*filled)[index] && Contains(pixels, pixel))
        (*filled)[index] =
            (board_from_image * pixel.homogeneous()).hnormalized();
    }
  }
}

std::vector<DenseMatch> MakeMatches(const ImageFeatures& image,
                                    const Board& board,
                                    const PixelLattice& lattice) {
  const ViewFeatures features(board, image);
  PointsByPixel filled(lattice.size());
  for (int width = 1; width <= kMaxWidth; ++width) {
    for (int row = 0; row + width < board.rows; ++row) {
      for (int column = 0; column + width < board.columns; ++column) {
        Corners pixels, points;
        if (features.FindSquare(column, row, width, &pixels, &points) &&
            IsPlausibleSquare(pixels))
          FillSquare(pixels, points, lattice, &filled);
      }
    }
  }
  std::vector<DenseMatch> matches;
  for (int index = 0; index < lattice.size(); ++index)
    if (filled[index]) matches.push_back({index, *filled[index]});
  return matches;
}

}  // namespace

PixelLattice MakePixelLattice(const ImageSize& size) {
  PixelLattice lattice;
  lattice.step_px =
      std::max(1, std::max(size.width, size.height) / kPixelsAlong);
  lattice.columns = (size.width - 1) / lattice.step_px + 1;
  lattice.rows = (size.height - 1) / lattice.step_px + 1;
  return lattice;
}

std::vector<DenseView> MakeDenseViews(const Dataset& dataset,
                                      const Pattern& pattern,
                                      const PixelLattice& lattice) {
  std::vector<DenseView> views;
  for (size_t i = 0; i < dataset.images.size(); ++i) {
    for (size_t b = 0; b < pattern.boards.size(); ++b) {
      std::vector<DenseMatch> matches =
          MakeMatches(dataset.images[i], pattern.boards[b], lattice);
      if (!matches.empty())
        views.push_back(
            {static_cast<int>(i), static_cast<int>(b), std::move(matches)});
    }
  }
  return views;
}

std::vector<BoardPointTriple> FindCommonMatches(const DenseView& first,
                                                const DenseView& second,
                                                const DenseView& third) {
  std::vector<BoardPointTriple> common;
  auto b = second.matches.begin(), c = third.matches.begin();
  for (const DenseMatch& match : first.matches) {
    while (b != second.matches.end() && b->pixel < match.pixel) ++b;
    while (c != third.matches.end() && c->pixel < match.pixel) ++c;
    if (b == second.matches.end() || c == third.matches.end()) break;
    if (b->pixel == match.pixel && c->pixel == match.pixel)
      common.push_back({match.point, b->point, c->point});
  }
  return common;
}

}  // namespace raygrid
