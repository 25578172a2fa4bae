// The three points observed at one pixel are collinear. In the first board's
// frame, they are
//   P1 = (X1, Y1, 0),  P2 = R2 (X2, Y2, 0) + t2,  P3 = R3 (X3, Y3, 0) + t3,
// and with the centre O = (ox, oy, -d), the 4 x 4 matrix of the homogeneous O,
// P1, P2, P3 has rank two. Its minors with O and two of the points imply that
// P1 is the projection of P2 and of P3 through O onto the plane of board 1:
//   (X1, Y1, 1) ~ K (P2 - O) = K [r21 r22 t2 - O] (X2, Y2, 1) = H2 (X2, Y2, 1)
//   K = [d 0 ox; 0 d oy; 0 0 1]
// with r21, r22 the first columns of R2, and likewise for H3. (Minors without O
// follow from these.) H2 and H3 are estimated linearly from matches, and yield
// the poses once K is known. Since r21 and r22 are orthogonal and of equal
// length, each H = [h1 h2 h3] gives two equations in W ~ K^-T K^-1:
//   h1' W h2 = 0,  h1' W h1 = h2' W h2
//   W ~ [w1 0 w2; 0 w1 w3; w2 w3 w4],  ox = -w2 / w1,  oy = -w3 / w1,
//   d^2 = w4 / w1 - ox^2 - oy^2.
// These are four linear equations for three unknowns. This is equivalent to
// calibrating a pinhole camera with square pixels, whose image plane is the
// first board, from two views of planes (Zhang, 2000).
//
// Uniqueness of W: it is a conic through the circular points of the boards'
// planes, two given by its form and two by each H. Five points determine a
// proper conic, and boards that are not parallel have different circular
// points, so that W is unique if no two boards are parallel. The equations of
// parallel boards are identical, or empty if one of them is the first board.
//
// d and -d give the same W and mirrored poses: with z pointing away from the
// camera, d is positive. The sign of H is chosen so that observed points are in
// front of the camera; det H > 0 then means that the other board faces the
// camera, too.
#include "initialization/planar_pose_solver.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <optional>

#include "initialization/median.h"

namespace raygrid {
namespace {

constexpr size_t kMinMatches = 8;
constexpr double kMinConditioning = 1e-7;
constexpr double kMinFractionInFront = 0.9;
constexpr double kOutlierLimitPerMedian = 6;
constexpr double kMinLossScaleM = 1e-9;

// Points of two boards that are observed at the same pixel.
struct PlaneMatch {
  Eigen::Vector2d from, to;
};

// Normalized coordinates: relative to the centroid of each board's matches, in
// a length unit that is common to all boards.
struct Normalization {
  std::array<Eigen::Vector2d, 3> centroid;
  double unit_m = 1;

  Eigen::Vector2d Apply(int view, const Eigen::Vector2d& point) const {
    return (point - centroid[view]) / unit_m;
  }
};

Normalization NormalizeMatches(const std::vector<BoardPointTriple>& matches) {
  Normalization normalization;
  const double count = static_cast<double>(matches.size());
  double sum = 0;
  for (int view = 0; view < 3; ++view) {
    Eigen::Vector2d& centroid = normalization.centroid[view];
    centroid.setZero();
    for (const auto& match : matches) centroid += match[view] / count;
    for (const auto& match : matches)
      sum += (match[view] - centroid).squaredNorm();
  }
  normalization.unit_m = std::sqrt(sum / (6 * count));
  return normalization;
}

Eigen::Vector2d Transfer(const Eigen::Matrix3d& homography,
                         const Eigen::Vector2d& point) {
  return (homography * point.homogeneous()).hnormalized();
}

// Estimates a homography by direct linear transformation (DLT).
Eigen::Matrix3d FitHomography(const std::vector<PlaneMatch>& matches) {
  Eigen::MatrixXd equations =
      Eigen::MatrixXd::Zero(std::max<size_t>(9, 2 * matches.size()), 9);
  for (size_t i = 0; i < matches.size(); ++i) {
    const Eigen::RowVector3d from = matches[i].from.homogeneous().transpose();
    for (int k = 0; k < 2; ++k) {
      equations.block<1, 3>(2 * i + k, 3 * k) = from;
      equations.block<1, 3>(2 * i + k, 6) = -matches[i].to[k] * from;
    }
  }
  const Eigen::HouseholderQR<Eigen::Ref<Eigen::MatrixXd>> qr(equations);
  const Eigen::Matrix<double, 9, 9> R =
      qr.matrixQR().topRows<9>().triangularView<Eigen::Upper>();
  const Eigen::JacobiSVD<Eigen::Matrix<double, 9, 9>> svd(R,
                                                          Eigen::ComputeFullV);
  const Eigen::Matrix<double, 9, 1> h = svd.matrixV().col(8);
  Eigen::Matrix3d homography;
  homography << h.segment<3>(0).transpose(), h.segment<3>(3).transpose(),
      h.segment<3>(6).transpose();
  return homography;
}

// Estimates a homography in two passes; the second one omits the outliers of
// the first.
Eigen::Matrix3d FitHomographyRobustly(const std::vector<PlaneMatch>& matches) {
  const Eigen::Matrix3d first = FitHomography(matches);
  std::vector<double> errors;
  for (const PlaneMatch& match : matches)
    errors.push_back((Transfer(first, match.from) - match.to).norm());
  const double limit = kOutlierLimitPerMedian * Median(errors) + 1e-12;
  std::vector<PlaneMatch> near;
  for (size_t i = 0; i < matches.size(); ++i)
    if (errors[i] <= limit) near.push_back(matches[i]);
  return near.size() == matches.size() ? first : FitHomography(near);
}

// Returns the homography with the sign that puts the observed points in front
// of the camera; nullopt if many points cannot be in front of it, or if the
// camera would observe the back of the board.
std::optional<Eigen::Matrix3d> EstimateFacingHomography(
    const std::vector<PlaneMatch>& matches) {
  Eigen::Matrix3d homography = FitHomographyRobustly(matches);
  if (!homography.allFinite()) return std::nullopt;
  if (homography.determinant() < 0) homography = -homography;
  const auto ahead = std::count_if(
      matches.begin(), matches.end(), [&](const PlaneMatch& match) {
        return homography.row(2).dot(match.from.homogeneous()) > 0;
      });
  if (static_cast<double>(ahead) <
      kMinFractionInFront * static_cast<double>(matches.size()))
    return std::nullopt;
  return homography / homography.leftCols<2>().norm();
}

// Returns the coefficients of a' W b with respect to (w1, w2, w3, w4).
Eigen::RowVector4d ConicRow(const Eigen::Vector3d& a,
                            const Eigen::Vector3d& b) {
  return {a.x() * b.x() + a.y() * b.y(), a.x() * b.z() + a.z() * b.x(),
          a.y() * b.z() + a.z() * b.y(), a.z() * b.z()};
}

// Solves for the centre (ox, oy, -d) in the first board's frame.
std::optional<Eigen::Vector3d> SolveCenter(const Eigen::Matrix3d& h2,
                                           const Eigen::Matrix3d& h3,
                                           double* conditioning) {
  Eigen::Matrix4d equations;
  int row = 0;
  for (const Eigen::Matrix3d& h : {h2, h3}) {
    equations.row(row++) = ConicRow(h.col(0), h.col(1));
    equations.row(row++) =
        ConicRow(h.col(0), h.col(0)) - ConicRow(h.col(1), h.col(1));
  }
  const Eigen::JacobiSVD<Eigen::Matrix4d> svd(equations, Eigen::ComputeFullV);
  *conditioning = svd.singularValues()[2];
  const Eigen::Vector4d w = svd.matrixV().col(3);
  const double ox = -w[1] / w[0], oy = -w[2] / w[0];
  const double d_squared = w[3] / w[0] - ox * ox - oy * oy;
  if (!(d_squared > 0) || !std::isfinite(d_squared)) return std::nullopt;
  return Eigen::Vector3d(ox, oy, -std::sqrt(d_squared));
}

// Returns the intrinsic matrix K for a centre in the first board's frame.
Eigen::Matrix3d MakeIntrinsicMatrix(const Eigen::Vector3d& center) {
  Eigen::Matrix3d k;
  k << -center.z(), 0, center.x(), 0, -center.z(), center.y(), 0, 0, 1;
  return k;
}

// Computes first_from_board from a homography and the centre.
Pose DecomposeHomography(const Eigen::Matrix3d& homography,
                         const Eigen::Vector3d& center) {
  const Eigen::Matrix3d columns =
      MakeIntrinsicMatrix(center).inverse() * homography;
  // Closest orthonormal pair to the first two columns, and their common scale.
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(
      columns.leftCols<2>(), Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Eigen::Matrix<double, 3, 2> pair =
      svd.matrixU() * svd.matrixV().transpose();
  Eigen::Matrix3d rotation;
  rotation << pair, pair.col(0).cross(pair.col(1));
  const double length = svd.singularValues().mean();
  return {Eigen::Quaterniond(rotation).normalized(),
          columns.col(2) / length + center};
}

std::vector<PlaneMatch> MatchWithFirst(
    const std::vector<BoardPointTriple>& matches,
    const Normalization& normalization, int view) {
  std::vector<PlaneMatch> to_first;
  for (const BoardPointTriple& match : matches)
    to_first.push_back({normalization.Apply(view, match[view]),
                        normalization.Apply(0, match[0])});
  return to_first;
}

ThreeViews ScaleToMetres(const ThreeViews& normalized,
                         const Normalization& normalization) {
  const auto lift_to_plane = [](const Eigen::Vector2d& point) {
    return Eigen::Vector3d(point.x(), point.y(), 0);
  };
  const Eigen::Vector3d first = lift_to_plane(normalization.centroid[0]);
  ThreeViews views;
  views.center = normalized.center * normalization.unit_m + first;
  for (int view = 1; view < 3; ++view) {
    const Pose& pose = normalized.first_from_board[view];
    views.first_from_board[view] = {
        pose.rotation,
        pose.translation * normalization.unit_m + first -
            pose.rotation * lift_to_plane(normalization.centroid[view])};
  }
  return views;
}

// Transfer error: the projection of another board's point through the centre
// onto the first board, minus the matching point there.
struct TransferError {
  const BoardPointTriple& match;

  template <typename T>
  bool operator()(const T* center, const T* rotation2, const T* translation2,
                  const T* rotation3, const T* translation3, T* error) const {
    Add(1, center, rotation2, translation2, error);
    Add(2, center, rotation3, translation3, error + 2);
    return true;
  }

  template <typename T>
  void Add(int view, const T* center, const T* rotation, const T* translation,
           T* error) const {
    const T point[3] = {T(match[view].x()), T(match[view].y()), T(0)};
    T moved[3];
    ceres::AngleAxisRotatePoint(rotation, point, moved);
    for (int k = 0; k < 3; ++k) moved[k] += translation[k] - center[k];
    for (int k = 0; k < 2; ++k)
      error[k] = center[k] - center[2] * moved[k] / moved[2] - T(match[0][k]);
  }
};

// Parameter blocks of three views for Ceres.
class ParameterBlocks {
 public:
  explicit ParameterBlocks(const ThreeViews& views) : center_(views.center) {
    for (int k = 0; k < 2; ++k) {
      const Eigen::AngleAxisd turn(views.first_from_board[k + 1].rotation);
      rotation_[k] = turn.angle() * turn.axis();
      translation_[k] = views.first_from_board[k + 1].translation;
    }
  }

  std::vector<double*> Pointers() {
    return {center_.data(), rotation_[0].data(), translation_[0].data(),
            rotation_[1].data(), translation_[1].data()};
  }

  ThreeViews ToViews() const {
    ThreeViews views;
    views.center = center_;
    for (int k = 0; k < 2; ++k)
      views.first_from_board[k + 1] = {RotationFromVector(rotation_[k]),
                                       translation_[k]};
    return views;
  }

 private:
  Eigen::Vector3d center_;
  std::array<Eigen::Vector3d, 2> rotation_, translation_;
};

// Returns the median over the matches of the larger one of both transfer
// errors.
double MedianError(const std::vector<BoardPointTriple>& matches,
                   const ThreeViews& views) {
  std::array<Eigen::Matrix3d, 3> homography;
  const Eigen::Matrix3d k = MakeIntrinsicMatrix(views.center);
  for (int view = 1; view < 3; ++view) {
    const Pose pose = views.CameraFromBoard(view);
    homography[view] << pose.rotation.toRotationMatrix().leftCols<2>(),
        pose.translation;
    homography[view] = k * homography[view];
  }
  std::vector<double> errors;
  for (const BoardPointTriple& match : matches)
    errors.push_back(
        std::max((Transfer(homography[1], match[1]) - match[0]).norm(),
                 (Transfer(homography[2], match[2]) - match[0]).norm()));
  return Median(errors);
}

double DistanceFromBoard(const std::vector<BoardPointTriple>& matches,
                         const ThreeViews& views) {
  std::vector<double> distances;
  for (const BoardPointTriple& match : matches)
    distances.push_back(
        (Eigen::Vector3d(match[0].x(), match[0].y(), 0) - views.center).norm());
  return Median(distances);
}

// Returns the standard deviation of the centre for errors with unit standard
// deviation.
double ComputeCenterStdDev(ceres::Problem* problem, ParameterBlocks* blocks) {
  ceres::Problem::EvaluateOptions options;
  options.parameter_blocks = blocks->Pointers();
  options.apply_loss_function = true;
  ceres::CRSMatrix sparse;
  problem->Evaluate(options, nullptr, nullptr, nullptr, &sparse);
  using Matrix15 = Eigen::Matrix<double, 15, 15>;
  Matrix15 normal = Matrix15::Zero();
  for (int row = 0; row < sparse.num_rows; ++row)
    for (int a = sparse.rows[row]; a < sparse.rows[row + 1]; ++a)
      for (int b = sparse.rows[row]; b < sparse.rows[row + 1]; ++b)
        normal(sparse.cols[a], sparse.cols[b]) +=
            sparse.values[a] * sparse.values[b];
  return std::sqrt(normal.inverse().topLeftCorner<3, 3>().trace());
}

}  // namespace

ThreeViewsSolution SolveThreeViews(
    const std::vector<BoardPointTriple>& matches) {
  ThreeViewsSolution solution;
  if (matches.size() < kMinMatches) return solution;
  solution.status = ThreeViewsStatus::kImpossible;
  const Normalization normalization = NormalizeMatches(matches);
  if (!(normalization.unit_m > 0)) return solution;
  const auto h2 =
      EstimateFacingHomography(MatchWithFirst(matches, normalization, 1));
  const auto h3 =
      EstimateFacingHomography(MatchWithFirst(matches, normalization, 2));
  if (!h2 || !h3) return solution;
  const auto center = SolveCenter(*h2, *h3, &solution.conditioning);
  if (solution.conditioning < kMinConditioning) {
    solution.status = ThreeViewsStatus::kParallelBoards;
    return solution;
  }
  if (!center) return solution;
  ThreeViews normalized;
  normalized.center = *center;
  normalized.first_from_board[1] = DecomposeHomography(*h2, *center);
  normalized.first_from_board[2] = DecomposeHomography(*h3, *center);
  solution.views = ScaleToMetres(normalized, normalization);
  solution.status = ThreeViewsStatus::kSolved;
  return solution;
}

ThreeViewsFit RefineThreeViews(const std::vector<BoardPointTriple>& matches,
                               ThreeViews* views) {
  ThreeViewsFit fit;
  if (matches.size() < kMinMatches) return fit;
  ParameterBlocks blocks(*views);
  const double scale_m =
      kOutlierLimitPerMedian * MedianError(matches, *views) + kMinLossScaleM;
  ceres::Problem problem;
  for (const BoardPointTriple& match : matches)
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<TransferError, 4, 3, 3, 3, 3, 3>(
            new TransferError{match}),
        new ceres::CauchyLoss(scale_m), blocks.Pointers());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 50;
  options.function_tolerance = 1e-10;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  const ThreeViews refined = blocks.ToViews();
  if (!summary.IsSolutionUsable() || !refined.center.allFinite() ||
      !(refined.center.z() < 0))
    return fit;
  *views = refined;
  fit.converged = true;
  fit.median_m = MedianError(matches, refined);
  fit.center_uncertainty = fit.median_m *
                           ComputeCenterStdDev(&problem, &blocks) /
                           DistanceFromBoard(matches, refined);
  return fit;
}

}  // namespace raygrid
