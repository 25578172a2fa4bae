#include "features/local_mapping.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace raygrid {
namespace {

constexpr int kMaxTerms = 3 + LocalMapping::kNumMonomials;

int NumTerms(int degree) { return (degree + 1) * (degree + 2) / 2; }

// (1, u, v, m(s)).
Eigen::Matrix<double, kMaxTerms, 1> Monomials(const Eigen::Vector2d& offset) {
  Eigen::Matrix<double, kMaxTerms, 1> monomials;
  monomials << 1, offset, CurvatureMonomials(offset);
  return monomials;
}

// Weighted least squares; false if the normal equations are near singular.
bool FitPolynomial(const std::vector<Correspondence>& correspondences,
                   int degree, LocalMapping* mapping) {
  const int terms = NumTerms(degree);
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(terms, terms);
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(terms, 2);
  // Near the origin of the pixels too, for the sake of precision.
  const Eigen::Vector2d origin = correspondences.front().pixel;
  for (const Correspondence& c : correspondences) {
    const Eigen::VectorXd m = Monomials(c.offset).head(terms);
    normal += c.weight * m * m.transpose();
    right += c.weight * m * (c.pixel - origin).transpose();
  }
  const Eigen::VectorXd scale = normal.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return false;
  normal = scale.asDiagonal() * normal * scale.asDiagonal();
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(normal);
  constexpr double kMinPivot = 1e-4;
  if (ldlt.info() != Eigen::Success || ldlt.vectorD().minCoeff() < kMinPivot)
    return false;
  const Eigen::MatrixXd solution =
      scale.asDiagonal() * ldlt.solve(scale.asDiagonal() * right);
  *mapping = LocalMapping();
  mapping->center = origin + solution.row(0).transpose();
  mapping->linear = solution.middleRows<2>(1).transpose();
  if (terms > 3)
    mapping->curvature.leftCols(terms - 3) =
        solution.bottomRows(terms - 3).transpose();
  return true;
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
