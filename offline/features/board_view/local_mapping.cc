#include "features/board_view/local_mapping.h"

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace raygrid {
namespace {

constexpr int NumTerms(int degree) { return (degree + 1) * (degree + 2) / 2; }

// Returns (1, s / (1 + h . s), m(s)), truncated to the polynomial's degree.
template <int kTerms>
Eigen::Matrix<double, kTerms, 1> Monomials(const Eigen::Vector2d& offset,
                                           const Eigen::Vector2d& perspective) {
  Eigen::Matrix<double, kTerms, 1> monomials;
  monomials << 1, offset / (1 + perspective.dot(offset)),
      CurvatureMonomials(offset).head<kTerms - 3>();
  return monomials;
}

// Solves normal equations after scaling their diagonal to 1; returns false if
// they are nearly singular.
template <int kTerms, int kColumns>
bool SolveScaled(Eigen::Matrix<double, kTerms, kTerms> normal,
                 const Eigen::Matrix<double, kTerms, kColumns>& right,
                 Eigen::Matrix<double, kTerms, kColumns>* solution) {
  const Eigen::Matrix<double, kTerms, 1> scale =
      normal.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return false;
  normal = (scale.asDiagonal() * normal * scale.asDiagonal()).eval();
  const Eigen::LDLT<Eigen::Matrix<double, kTerms, kTerms>> ldlt(normal);
  constexpr double kMinPivot = 1e-4;
  if (ldlt.info() != Eigen::Success || ldlt.vectorD().minCoeff() < kMinPivot)
    return false;
  const Eigen::Matrix<double, kTerms, kColumns> scaled =
      scale.asDiagonal() * right;
  *solution = scale.asDiagonal() * ldlt.solve(scaled);
  return true;
}

// Fits by weighted least squares; returns false if the normal equations are
// nearly singular.
template <int kDegree>
bool FitPolynomial(const std::vector<Correspondence>& correspondences,
                   const Eigen::Vector2d& perspective, LocalMapping* mapping) {
  constexpr int kTerms = NumTerms(kDegree);
  using Normal = Eigen::Matrix<double, kTerms, kTerms>;
  using Solution = Eigen::Matrix<double, kTerms, 2>;
  Normal normal = Normal::Zero();
  Solution right = Solution::Zero();
  // Pixels are relative to the first one for numerical precision.
  const Eigen::Vector2d origin = correspondences.front().pixel;
  for (const Correspondence& c : correspondences) {
    const auto m = Monomials<kTerms>(c.offset, perspective);
    const Eigen::Matrix<double, kTerms, 1> weighted = c.weight * m;
    normal.noalias() += weighted * m.transpose();
    right.noalias() += weighted * (c.pixel - origin).transpose();
  }
  Solution solution;
  if (!SolveScaled(normal, right, &solution)) return false;
  *mapping = LocalMapping();
  mapping->perspective = perspective;
  mapping->center = origin + solution.row(0).transpose();
  mapping->linear = solution.template middleRows<2>(1).transpose();
  mapping->curvature.leftCols(kTerms - 3) =
      solution.bottomRows(kTerms - 3).transpose();
  return true;
}

// Fits a mapping with given perspective and the highest degree that the
// correspondences determine.
int FitPolynomial(const std::vector<Correspondence>& correspondences,
                  int max_degree, const Eigen::Vector2d& perspective,
                  LocalMapping* mapping) {
  for (int degree = max_degree; degree >= 1; --degree) {
    // Requires two correspondences more than coefficients, since an
    // interpolating polynomial would reproduce the noise.
    const int spare = degree == 1 ? 0 : 2;
    const auto fit = degree == 3   ? FitPolynomial<3>
                     : degree == 2 ? FitPolynomial<2>
                                   : FitPolynomial<1>;
    if (static_cast<int>(correspondences.size()) >= NumTerms(degree) + spare &&
        fit(correspondences, perspective, mapping))
      return degree;
  }
  return 0;
}

// Fits a homography and returns its perspective; false if undetermined.
bool FitPerspective(const std::vector<Correspondence>& correspondences,
                    Eigen::Vector2d* perspective) {
  constexpr size_t kMinCount = 5;
  if (correspondences.size() < kMinCount) return false;
  using Row = Eigen::Matrix<double, 1, 8>;
  Eigen::Matrix<double, 8, 8> normal = Eigen::Matrix<double, 8, 8>::Zero();
  Eigen::Matrix<double, 8, 1> right = Eigen::Matrix<double, 8, 1>::Zero();
  const Eigen::Vector2d origin = correspondences.front().pixel;
  for (const Correspondence& c : correspondences) {
    const double u = c.offset.x(), v = c.offset.y();
    const Eigen::Vector2d p = c.pixel - origin;
    Row x, y;
    x << 1, u, v, 0, 0, 0, -u * p.x(), -v * p.x();
    y << 0, 0, 0, 1, u, v, -u * p.y(), -v * p.y();
    normal.noalias() += c.weight * (x.transpose() * x + y.transpose() * y);
    right.noalias() +=
        c.weight * (p.x() * x.transpose() + p.y() * y.transpose());
  }
  Eigen::Matrix<double, 8, 1> homography;
  if (!SolveScaled(normal, right, &homography)) return false;
  *perspective = homography.tail<2>();
  constexpr double kMinDenominator = 0.2;
  return std::all_of(correspondences.begin(), correspondences.end(),
                     [&](const Correspondence& c) {
                       return 1 + perspective->dot(c.offset) > kMinDenominator;
                     });
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

double LocalMapping::CircleWidthPx() const {
  return linear.jacobiSvd().singularValues()[1];
}

int FitLocalMapping(const std::vector<Correspondence>& correspondences,
                    int max_degree, LocalMapping* mapping) {
  return FitPolynomial(correspondences, max_degree, Eigen::Vector2d::Zero(),
                       mapping);
}

int FitPerspectiveMapping(const std::vector<Correspondence>& correspondences,
                          int max_degree, LocalMapping* mapping) {
  Eigen::Vector2d perspective;
  return FitPerspective(correspondences, &perspective)
             ? FitPolynomial(correspondences, max_degree, perspective, mapping)
             : 0;
}

}  // namespace raygrid
