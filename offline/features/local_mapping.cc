#include "features/local_mapping.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace raygrid {
namespace {

constexpr int NumTerms(int degree) { return (degree + 1) * (degree + 2) / 2; }

// (1, u, v, m(s)), as far as the degree.
template <int kTerms>
Eigen::Matrix<double, kTerms, 1> Monomials(const Eigen::Vector2d& offset) {
  Eigen::Matrix<double, kTerms, 1> monomials;
  monomials << 1, offset, CurvatureMonomials(offset).head<kTerms - 3>();
  return monomials;
}

// Weighted least squares; false if the normal equations are near singular.
template <int kDegree>
bool FitPolynomial(const std::vector<Correspondence>& correspondences,
                   LocalMapping* mapping) {
  constexpr int kTerms = NumTerms(kDegree);
  using Normal = Eigen::Matrix<double, kTerms, kTerms>;
  using Solution = Eigen::Matrix<double, kTerms, 2>;
  Normal normal = Normal::Zero();
  Solution right = Solution::Zero();
  // Near the origin of the pixels too, for the sake of precision.
  const Eigen::Vector2d origin = correspondences.front().pixel;
  for (const Correspondence& c : correspondences) {
    const auto m = Monomials<kTerms>(c.offset);
    const Eigen::Matrix<double, kTerms, 1> weighted = c.weight * m;
    normal.noalias() += weighted * m.transpose();
    right.noalias() += weighted * (c.pixel - origin).transpose();
  }
  const Eigen::Matrix<double, kTerms, 1> scale =
      normal.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return false;
  normal = (scale.asDiagonal() * normal * scale.asDiagonal()).eval();
  const Eigen::LDLT<Normal> ldlt(normal);
  constexpr double kMinPivot = 1e-4;
  if (ldlt.info() != Eigen::Success || ldlt.vectorD().minCoeff() < kMinPivot)
    return false;
  const Solution scaled = scale.asDiagonal() * right;
  const Solution solution = scale.asDiagonal() * ldlt.solve(scaled);
  *mapping = LocalMapping();
  mapping->center = origin + solution.row(0).transpose();
  mapping->linear = solution.template middleRows<2>(1).transpose();
  mapping->curvature.leftCols(kTerms - 3) =
      solution.bottomRows(kTerms - 3).transpose();
  return true;
}

bool FitPolynomial(const std::vector<Correspondence>& correspondences,
                   int degree, LocalMapping* mapping) {
  switch (degree) {
    case 3:
      return FitPolynomial<3>(correspondences, mapping);
    case 2:
      return FitPolynomial<2>(correspondences, mapping);
    default:
      return FitPolynomial<1>(correspondences, mapping);
  }
}

}  // namespace

Eigen::Matrix<double, LocalMapping::kNumMonomials, 1> CurvatureMonomials(
    const Eigen::Vector2d& offset) {
  const double u = offset.x(), v = offset.y();
  Eigen::Matrix<double, LocalMapping::kNumMonomials, 1> m;
  m << u * u, u * v, v * v, u * u * u, u * u * v, u * v * v, v * v * v;
  return m;
}

Eigen::Vector2d LocalMapping::operator()(const Eigen::Vector2d& offset) const {
  return center + linear * offset / (1 + perspective.dot(offset)) +
         curvature * CurvatureMonomials(offset);
}

double LocalMapping::SpacingPx() const {
  return std::min(linear.col(0).norm(), linear.col(1).norm());
}

int FitLocalMapping(const std::vector<Correspondence>& correspondences,
                    int max_degree, LocalMapping* mapping) {
  for (int degree = max_degree; degree >= 1; --degree) {
    // Two more than needed: a polynomial through all points would follow
    // their errors.
    const int spare = degree == 1 ? 0 : 2;
    if (static_cast<int>(correspondences.size()) >= NumTerms(degree) + spare &&
        FitPolynomial(correspondences, degree, mapping))
      return degree;
  }
  return 0;
}

}  // namespace raygrid
