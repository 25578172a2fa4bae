#include "simulation/board_surface.h"

#include <cmath>

namespace raygrid {

BoardSurface::BoardSurface(const Board& board, double bend_m,
                           double paper_margin_squares)
    : curvature_(board, bend_m), ink_(BoardAppearance(board)) {
  const Area extent = BoardAppearance(board).extent_m();
  const double margin_m = paper_margin_squares * board.square_m;
  paper_m_ = {extent.x0 - margin_m, extent.y0 - margin_m, extent.x1 + margin_m,
              extent.y1 + margin_m};
}

std::optional<BoardSurface::Point> BoardSurface::Intersect(
    const ObservationLine& line) const {
  const Eigen::Vector3d& o = line.origin;
  const Eigen::Vector3d& d = line.direction;
  if (!(d.z() > 0)) return std::nullopt;
  // The intersection with the surface z = kx x^2 + ky y^2 solves a t^2 + b t +
  // c = 0.
  const double kx = curvature_.x2_coefficient(),
               ky = curvature_.y2_coefficient();
  const double x = o.x() - curvature_.center_m().x();
  const double y = o.y() - curvature_.center_m().y();
  const double a = kx * d.x() * d.x() + ky * d.y() * d.y();
  const double b = 2 * (kx * x * d.x() + ky * y * d.y()) - d.z();
  const double c = kx * x * x + ky * y * y - o.z();
  // The root that converges to the plane's intersection as the deformation
  // vanishes.
  const double discriminant = b * b - 4 * a * c;
  if (!(discriminant >= 0)) return std::nullopt;
  const double denominator = b + std::copysign(std::sqrt(discriminant), b);
  const double t = -2 * c / denominator;
  if (!(b < 0) || !(t > 0) || !std::isfinite(t)) return std::nullopt;
  return Point{o.head<2>() + t * d.head<2>(), t};
}

double BoardSurface::PaperFraction(const Eigen::Vector2d& p,
                                   const Footprint& footprint) const {
  const double inside_m = std::min({p.x() - paper_m_.x0, paper_m_.x1 - p.x(),
                                    p.y() - paper_m_.y0, paper_m_.y1 - p.y()});
  if (inside_m > footprint.radius_m()) return 1;
  if (inside_m < -footprint.radius_m()) return 0;
  return footprint.ComputeFractionBeyondLine({1, 0}, p.x() - paper_m_.x0) *
         footprint.ComputeFractionBeyondLine({-1, 0}, paper_m_.x1 - p.x()) *
         footprint.ComputeFractionBeyondLine({0, 1}, p.y() - paper_m_.y0) *
         footprint.ComputeFractionBeyondLine({0, -1}, paper_m_.y1 - p.y());
}

}  // namespace raygrid
