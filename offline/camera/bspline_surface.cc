#include "camera/bspline_surface.h"

#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cassert>
#include <cmath>

namespace raygrid {
namespace {

// Cell index and fractional position in the cell along one axis.
struct CellPosition {
  int cell;
  double t;
};

CellPosition Locate(double position, double start, double cell_size,
                    int num_cells) {
  const double u = (position - start) / cell_size;
  const int cell =
      std::clamp(static_cast<int>(std::floor(u)), 0, num_cells - 1);
  return {cell, u - cell};
}

std::array<double, 4> Weights(double t) {
  const double s = 1 - t;
  return {s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
          (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6, t * t * t / 6};
}

std::array<double, 4> WeightDerivatives(double t, double cell_size) {
  const double s = 1 - t;
  return {-s * s / 2 / cell_size, (3 * t * t - 4 * t) / 2 / cell_size,
          (-3 * t * t + 2 * t + 1) / 2 / cell_size, t * t / 2 / cell_size};
}

// Normal matrix of a surface's control points. A sample couples control points
// at most three columns and rows apart, so each of them is coupled with 7 x 7
// control points.
class SurfaceNormalMatrix {
 public:
  SurfaceNormalMatrix(int columns, int rows)
      : columns_(columns), rows_(rows), neighbor_blocks_(columns * rows) {
    for (auto& block : neighbor_blocks_) block.fill(0);
  }

  // Adds weight * row^T row for a sparse row, indexed by control point.
  template <size_t N>
  void AddProduct(const std::array<int, N>& point,
                  const std::array<double, N>& row, double weight) {
    for (size_t a = 0; a < N; ++a)
      for (size_t b = 0; b < N; ++b)
        NeighborBlock(point[a], point[b]) += weight * row[a] * row[b];
  }

  Eigen::SparseMatrix<double> ToSparse() const {
    std::vector<Eigen::Triplet<double>> triplets;
    for (int p = 0; p < columns_ * rows_; ++p) {
      for (int k = 0; k < 49; ++k) {
        const int column = p % columns_ + k % 7 - 3;
        const int row = p / columns_ + k / 7 - 3;
        if (neighbor_blocks_[p][k] != 0)
          triplets.emplace_back(p, row * columns_ + column,
                                neighbor_blocks_[p][k]);
      }
    }
    Eigen::SparseMatrix<double> matrix(columns_ * rows_, columns_ * rows_);
    matrix.setFromTriplets(triplets.begin(), triplets.end());
    return matrix;
  }

 private:
  double& NeighborBlock(int p, int q) {
    const int dx = q % columns_ - p % columns_;
    const int dy = q / columns_ - p / columns_;
    return neighbor_blocks_[p][(dy + 3) * 7 + dx + 3];
  }

  int columns_, rows_;
  std::vector<std::array<double, 49>> neighbor_blocks_;
};

// Adds a penalty on second differences along both axes.
void AddSmoothness(int columns, int rows, double weight,
                   SurfaceNormalMatrix* normal) {
  const std::array<double, 3> difference = {1, -2, 1};
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const int k = j * columns + i;
      if (i > 0 && i + 1 < columns)
        normal->AddProduct<3>({k - 1, k, k + 1}, difference, weight);
      if (j > 0 && j + 1 < rows)
        normal->AddProduct<3>({k - columns, k, k + columns}, difference,
                              weight);
    }
  }
}

// Whether the surface is folded at a control point, according to its
// neighbours.
bool IsFoldedAt(const BSplineSurface& surface, int index,
                const UnfoldedSide& side) {
  const int columns = surface.columns();
  const int column = index % columns, row = index / columns;
  const auto point = [&](int c, int r) -> const Eigen::Vector2d& {
    return surface.points()[std::clamp(r, 0, surface.rows() - 1) * columns +
                            std::clamp(c, 0, columns - 1)];
  };
  Eigen::Matrix2d derivative;
  derivative << point(column + 1, row) - point(column - 1, row),
      point(column, row + 1) - point(column, row - 1);
  return side.IsFolded(derivative);
}

}  // namespace

BSplineSurface::BSplineSurface(const Area& area, int columns, int rows)
    : area_(area),
      columns_(columns),
      rows_(rows),
      points_(columns * rows, Eigen::Vector2d::Zero()) {
  assert(columns >= 4 && rows >= 4);
}

std::vector<Eigen::Vector2d> BSplineSurface::SamplePixels(int per_cell) const {
  std::vector<Eigen::Vector2d> pixels;
  const int num_x = (columns_ - 3) * per_cell;
  const int num_y = (rows_ - 3) * per_cell;
  for (int j = 0; j <= num_y; ++j)
    for (int i = 0; i <= num_x; ++i)
      pixels.emplace_back(area_.x0 + area_.width() * i / num_x,
                          area_.y0 + area_.height() * j / num_y);
  return pixels;
}

SplineSupport BSplineSurface::Support(const Eigen::Vector2d& pixel) const {
  const CellPosition x =
      Locate(pixel.x(), area_.x0, cell_width(), columns_ - 3);
  const CellPosition y = Locate(pixel.y(), area_.y0, cell_height(), rows_ - 3);
  return {x.cell,
          y.cell,
          Weights(x.t),
          Weights(y.t),
          WeightDerivatives(x.t, cell_width()),
          WeightDerivatives(y.t, cell_height())};
}

// Same value, bit by bit, as the overload with derivatives, in half the time.
Eigen::Vector2d BSplineSurface::Evaluate(const Eigen::Vector2d& pixel) const {
  const CellPosition x =
      Locate(pixel.x(), area_.x0, cell_width(), columns_ - 3);
  const CellPosition y = Locate(pixel.y(), area_.y0, cell_height(), rows_ - 3);
  const std::array<double, 4> wx = Weights(x.t), wy = Weights(y.t);
  Eigen::Vector2d value(0, 0);
  for (int m = 0; m < 4; ++m) {
    const Eigen::Vector2d* row = &points_[(y.cell + m) * columns_ + x.cell];
    Eigen::Vector2d sum(0, 0);
    for (int n = 0; n < 4; ++n) sum += wx[n] * row[n];
    value += wy[m] * sum;
  }
  return value;
}

Eigen::Vector2d BSplineSurface::Evaluate(const Eigen::Vector2d& pixel,
                                         Eigen::Matrix2d* derivative) const {
  const SplineSupport support = Support(pixel);
  Eigen::Vector2d value(0, 0), dx(0, 0), dy(0, 0);
  for (int m = 0; m < 4; ++m) {
    const Eigen::Vector2d* row =
        &points_[(support.row + m) * columns_ + support.column];
    Eigen::Vector2d sum(0, 0), sum_dx(0, 0);
    for (int n = 0; n < 4; ++n) {
      sum += support.wx[n] * row[n];
      sum_dx += support.dwx[n] * row[n];
    }
    value += support.wy[m] * sum;
    dx += support.wy[m] * sum_dx;
    dy += support.dwy[m] * sum;
  }
  derivative->col(0) = dx;
  derivative->col(1) = dy;
  return value;
}

int ComputeDominantHandedness(const BSplineSurface& surface) {
  constexpr int kSteps = 8;
  const Area& area = surface.area();
  const Eigen::Vector2d extent(area.width(), area.height());
  int sum = 0;
  for (int j = 0; j <= kSteps; ++j)
    for (int i = 0; i <= kSteps; ++i) {
      const Eigen::Vector2d part(double(i) / kSteps - 0.5,
                                 double(j) / kSteps - 0.5);
      Eigen::Matrix2d derivative;
      surface.Evaluate(area.center() + part.cwiseProduct(extent / 2),
                       &derivative);
      sum += derivative.determinant() < 0 ? -1 : 1;
    }
  return sum < 0 ? -1 : 1;
}

UnfoldedSide ComputeUnfoldedSide(const BSplineSurface& surface) {
  constexpr double kMaxStep = 1 / 32.0;  // relative to the longer side
  const Area& area = surface.area();
  const UnfoldedSide side = {ComputeDominantHandedness(surface),
                             kMaxStep * std::max(area.width(), area.height())};
  for (int k = 0; k < surface.num_points(); ++k)
    if (IsFoldedAt(surface, k, side)) return side;
  return {};
}

int NumControlPoints(double extent_px, double knot_spacing_px) {
  return std::max(1, static_cast<int>(
                         std::ceil(extent_px / knot_spacing_px - 1e-9))) +
         3;
}

BSplineSurface FitSurface(const Area& area, int columns, int rows,
                          const std::vector<SurfaceSample>& samples,
                          double smoothness) {
  BSplineSurface surface(area, columns, rows);
  SurfaceNormalMatrix normal(columns, rows);
  Eigen::MatrixX2d right = Eigen::MatrixX2d::Zero(surface.num_points(), 2);
  for (const SurfaceSample& sample : samples) {
    const SplineSupport support = surface.Support(sample.pixel);
    std::array<int, 16> index;
    std::array<double, 16> weight;
    for (int k = 0; k < 16; ++k) {
      index[k] = (support.row + k / 4) * columns + support.column + k % 4;
      weight[k] = support.wy[k / 4] * support.wx[k % 4];
      right.row(index[k]) +=
          sample.weight * weight[k] * sample.value.transpose();
    }
    normal.AddProduct<16>(index, weight, sample.weight);
  }
  AddSmoothness(columns, rows, smoothness, &normal);

  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(
      normal.ToSparse());
  const Eigen::MatrixX2d solution = solver.solve(right);
  for (int k = 0; k < surface.num_points(); ++k)
    surface.points()[k] = solution.row(k).transpose();
  return surface;
}

}  // namespace raygrid
