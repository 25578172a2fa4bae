#include "adjustment/shared_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace raygrid {
namespace {

constexpr std::array<double, 5> kLengths = {1, 2, 4, 8, 16};
// Distances between features, in spacings, up to which their products are
// summed up; the first is a feature with itself.
constexpr std::array<double, 6> kDistances = {0, 1.5, 3, 6, 12, 1e9};
constexpr int kNumDistances = static_cast<int>(kDistances.size());
using Moments = Eigen::Array<double, kNumDistances, 1>;

// The places of a view's points on the board, in spacings of those seen.
Eigen::Matrix2Xd PlacesOf(const ViewJacobian& view,
                          const std::vector<Eigen::Vector3d>& points) {
  Eigen::Matrix2Xd places(2, view.count());
  for (int i = 0; i < view.count(); ++i)
    places.col(i) = points[view.points[i]].head<2>();
  if (view.count() < 2) return places;
  constexpr int kEnough = 100;  // features, evenly chosen, tell the spacing
  std::vector<double> nearest2;
  for (int i = 0; i < view.count(); i += 1 + view.count() / kEnough) {
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < view.count(); ++k)
      if (k != i)
        least = std::min(least, (places.col(k) - places.col(i)).squaredNorm());
    nearest2.push_back(least);
  }
  std::nth_element(nearest2.begin(), nearest2.begin() + nearest2.size() / 2,
                   nearest2.end());
  const double spacing = std::sqrt(nearest2[nearest2.size() / 2]);
  if (spacing > 0) places /= spacing;
  return places;
}

// Pairs of a view's features, each once, and the distance that they count for.
struct Pair {
  int first, second, distance;
};

constexpr int kMaxFeatures = 250;  // of a view; others are left out

std::vector<Pair> PairsOf(const Eigen::Matrix2Xd& places) {
  const int count = static_cast<int>(places.cols());
  const int step = (count + kMaxFeatures - 1) / kMaxFeatures;
  std::vector<Pair> pairs;
  for (int i = 0; i < count; i += step)
    for (int k = 0; k <= i; k += step) {
      const double d = (places.col(k) - places.col(i)).norm();
      int distance = i == k ? 0 : 1;
      while (distance > 0 && d > kDistances[distance]) ++distance;
      pairs.push_back({i, k, distance});
    }
  return pairs;
}

// Sums of products of errors, by distance.
class PairProducts {
 public:
  PairProducts(const LinearResponse& response,
               const std::vector<Eigen::Vector3d>& points, int camera) {
    for (const ViewJacobian& view : response.jacobians())
      num_views_ += view.camera == camera;
    // Enough for the products' means, of views evenly chosen.
    constexpr int kMaxViews = 60;
    const int step = (num_views_ + kMaxViews - 1) / kMaxViews;
    int index = 0;
    for (const ViewJacobian& view : response.jacobians()) {
      pairs_.emplace_back();
      if (view.camera != camera || index++ % step != 0) continue;
      pairs_.back() = PairsOf(PlacesOf(view, points));
      for (const Pair& pair : pairs_.back()) ++counts_[pair.distance];
    }
  }
  const Moments& counts() const { return counts_; }
  int num_views() const { return num_views_; }

  Moments Of(const ViewErrors& errors) const {
    Moments moments = Moments::Zero();
    for (size_t v = 0; v < errors.size(); ++v)
      for (const Pair& pair : pairs_[v])
        moments[pair.distance] +=
            errors[v].col(pair.first).dot(errors[v].col(pair.second));
    return moments;
  }

 private:
  std::vector<std::vector<Pair>> pairs_;  // by view
  Moments counts_ = Moments::Zero();
  int num_views_ = 0;
};

// How far the errors of each view by themselves would move some pixels: what
// counts of noise that neighbours share, however much of it poses take up.
class Influences {
 public:
  // False if equations are singular.
  bool Prepare(const LinearResponse& response, int camera, int first,
               const Eigen::MatrixXd& moves) {
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(response.layout().num_all(),
                                                  moves.rows()),
                    x;
    right.middleRows(first, moves.cols()) = moves.transpose();
    if (!response.Solve(right, &x)) return false;
    for (const ViewJacobian& view : response.jacobians())
      by_view_.emplace_back(view.camera == camera ? 2 * view.count() : 0,
                            moves.rows());
    for (Eigen::Index k = 0; k < moves.rows(); ++k) {
      const ViewErrors by_move = response.ErrorsBy(x.col(k));
      for (size_t v = 0; v < by_view_.size(); ++v)
        if (by_view_[v].rows() > 0) by_view_[v].col(k) = by_move[v].reshaped();
    }
    return true;
  }
  // Squares, a row for each view and a column for each move.
  Eigen::MatrixXd Of(const ViewErrors& errors) const {
    Eigen::MatrixXd squares = Eigen::MatrixXd::Zero(
        static_cast<Eigen::Index>(errors.size()), by_view_.front().cols());
    for (size_t v = 0; v < by_view_.size(); ++v)
      if (by_view_[v].rows() > 0)
        squares.row(static_cast<Eigen::Index>(v)) =
            (by_view_[v].transpose() * errors[v].reshaped()).cwiseAbs2();
    return squares;
  }

 private:
  std::vector<Eigen::MatrixXd> by_view_;
};

// The sums that tell of errors' noise.
struct Told {
  Moments products;
  Eigen::MatrixXd influence;  // of views on moves
};

ViewErrors NoErrors(const LinearResponse& response) {
  ViewErrors errors;
  for (const ViewJacobian& view : response.jacobians())
    errors.push_back(Eigen::Matrix2Xd::Zero(2, view.count()));
  return errors;
}

ViewErrors ErrorsOf(const LinearResponse& response) {
  ViewErrors errors;
  for (const ViewJacobian& view : response.jacobians())
    errors.push_back(view.error);
  return errors;
}

// The sums of drawn errors and gradients, less what adjustment takes up of
// them, in the mean; nothing if it cannot be solved for.
template <typename Tell, typename DrawErrors, typename DrawGradient>
std::optional<Told> ToldBy(const LinearResponse& response, int num_draws,
                           const Tell& tell, const DrawErrors& draw_errors,
                           const DrawGradient& draw_gradient) {
  std::vector<ViewErrors> drawn;
  Eigen::MatrixXd right(response.layout().num_all(), num_draws), x;
  for (int k = 0; k < num_draws; ++k) {
    drawn.push_back(draw_errors());
    right.col(k) = response.Gradient(drawn.back()) + draw_gradient();
  }
  if (!response.Solve(right, &x)) return std::nullopt;
  std::optional<Told> mean;
  for (int k = 0; k < num_draws; ++k) {
    ViewErrors left = response.ErrorsBy(x.col(k));
    for (size_t v = 0; v < left.size(); ++v) left[v] = drawn[k][v] - left[v];
    Told told = tell(left);
    told.products /= num_draws;
    told.influence /= num_draws;
    if (mean) {
      mean->products += told.products;
      mean->influence += told.influence;
    } else {
      mean = told;
    }
  }
  return mean;
}

// The variances of two parts of the noise, and how far products are from them:
// the sum of squares, each in units of what it varies by with white noise of
// variance 1.
struct NoiseFit {
  double own = 0, shared = 0, distance2 = 0;
};

// Each view's influence, in the mean over moves, in units of what white noise
// does in all views.
Eigen::VectorXd InUnitsOf(const Told& white, const Told& told) {
  const Eigen::RowVectorXd units = white.influence.colwise().sum();
  return (told.influence.array().rowwise() / units.array()).rowwise().mean();
}

// The number of views of equal influence that scatter as much together as
// these.
double NumEqual(const Eigen::VectorXd& influences) {
  return std::pow(influences.sum(), 2) / influences.squaredNorm();
}

// The part of an excess over white noise's influence, in units of that, which
// chance hardly makes of so many equal views: next to nothing of one standard
// deviation, nearly all of many.
double Significant(double excess, double num_views) {
  if (!(excess > 0)) return excess;
  const double square = excess * excess * num_views / 2;  // of deviations
  return excess * square / (1 + square);
}

// The parts that have the observed sum of squares and the observed influence,
// in the mean over moves, in units of what white noise has.
NoiseFit FitParts(const Told& observed, const Told& own, const Told& shared,
                  const Moments& counts) {
  const auto influence = [&own](const Told& told) {
    return InUnitsOf(own, told).sum();
  };
  const double squares = observed.products[0];
  const double if_white = squares / own.products[0];
  Eigen::Matrix2d matrix;
  matrix << own.products[0], shared.products[0], 1, influence(shared);
  const double excess = influence(observed) / if_white - 1;
  const Eigen::Vector2d right(
      squares,
      if_white * (1 + Significant(excess, NumEqual(InUnitsOf(own, own)))));
  Eigen::Vector2d variances = matrix.inverse() * right;
  if (!(variances[1] >= 0)) variances = {if_white, 0};
  if (!(variances[0] >= 0)) variances = {0, right[1] / matrix(1, 1)};
  const Moments left = observed.products - variances[0] * own.products -
                       variances[1] * shared.products;
  // A feature with itself is two squares, of variance 2 each; a pair two
  // products, of variance 1 each.
  Moments weights = (counts > 0).select(1 / (2 * counts.max(1)), 0);
  weights[0] /= 2;
  return {std::max(variances[0], 0.0), std::max(variances[1], 0.0),
          (weights * left * left).sum()};
}

// The parts with each length, each as likely as its distance tells.
ObservationNoise Mean(const std::vector<NoiseFit>& fits, double noise_px) {
  double least = std::numeric_limits<double>::infinity(), sum = 0;
  for (const NoiseFit& fit : fits) least = std::min(least, fit.distance2);
  const double unit = 2 * std::pow(noise_px, 4);
  const auto likelihood = [&](const NoiseFit& fit) {
    return std::exp(-(fit.distance2 - least) / unit);
  };
  for (const NoiseFit& fit : fits) sum += likelihood(fit);
  ObservationNoise noise = {noise_px, 0, {}};
  double own = 0;
  for (size_t k = 0; k < fits.size(); ++k) {
    constexpr double kUnlikely = 0.01;
    const double part = likelihood(fits[k]) / sum;
    own += part * fits[k].own;
    if (part > kUnlikely && fits[k].shared > 0)
      noise.shared.push_back({kLengths[k], std::sqrt(part * fits[k].shared)});
  }
  noise.own_px = std::sqrt(own);
  return noise;
}

}  // namespace

SmoothField::SmoothField(const Eigen::Matrix2Xd& places, double length) {
  // Weights exp(-d^2 / length^2) of nodes at d have sums of products that fall
  // with distance as exp(-d^2 / 2 length^2).
  constexpr double kNodesPerLength = 1.25;
  const double unit = kNodesPerLength / length;
  const Eigen::Index count = places.cols();
  first_.resize(2, count);
  by_x_.resize(kNear, count);
  by_y_.resize(kNear, count);
  if (count == 0) return;
  const Eigen::Vector2d start = places.rowwise().minCoeff();
  Eigen::Vector2i last(0, 0);
  for (Eigen::Index i = 0; i < count; ++i)
    for (int axis = 0; axis < 2; ++axis) {
      const double place = (places(axis, i) - start[axis]) * unit;
      const int first = static_cast<int>(std::floor(place));
      first_(axis, i) = first;
      last[axis] = std::max(last[axis], first);
      auto weights = (axis == 0 ? by_x_ : by_y_).col(i);
      for (int k = 0; k < kNear; ++k) {
        const double d =
            (place - first - (k - (kNear / 2 - 1))) / kNodesPerLength;
        weights[k] = std::exp(-d * d);
      }
      weights.normalize();
    }
  columns_ = last.x() + kNear;
  rows_ = last.y() + kNear;
}

Eigen::Matrix2Xd SmoothField::Draw(std::mt19937* random_bits) const {
  const Eigen::Index count = first_.cols();
  Eigen::Matrix2Xd drawn(2, count);
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::MatrixXd nodes =
        RandomSigns(static_cast<Eigen::Index>(columns_) * rows_, random_bits)
            .reshaped(columns_, rows_);
    for (Eigen::Index i = 0; i < count; ++i)
      drawn(axis, i) = by_x_.col(i).dot(
          nodes.block<kNear, kNear>(first_(0, i), first_(1, i)) * by_y_.col(i));
  }
  return drawn;
}

double SmoothField::VarianceOf(const Eigen::Matrix2Xd& weights) const {
  double variance = 0;
  for (int axis = 0; axis < 2; ++axis) {
    Eigen::MatrixXd nodes = Eigen::MatrixXd::Zero(columns_, rows_);
    for (Eigen::Index i = 0; i < first_.cols(); ++i)
      nodes.block<kNear, kNear>(first_(0, i), first_(1, i)) +=
          weights(axis, i) * by_x_.col(i) * by_y_.col(i).transpose();
    variance += nodes.squaredNorm();
  }
  return variance;
}

ViewErrors OwnNoise(const LinearResponse& response, std::mt19937* random_bits) {
  ViewErrors errors;
  for (const ViewJacobian& view : response.jacobians())
    errors.push_back(
        RandomSigns(2 * view.count(), random_bits).reshaped(2, view.count()));
  return errors;
}

ViewErrors SharedNoise(const std::vector<SmoothField>& fields,
                       std::mt19937* random_bits) {
  ViewErrors errors;
  for (const SmoothField& field : fields)
    errors.push_back(field.Draw(random_bits));
  return errors;
}

std::vector<SmoothField> SmoothFields(
    const LinearResponse& response, const std::vector<Eigen::Vector3d>& points,
    double length) {
  std::vector<SmoothField> fields;
  for (const ViewJacobian& view : response.jacobians())
    fields.emplace_back(PlacesOf(view, points), length);
  return fields;
}

double ObservationNoise::SharedPx() const {
  double variance = 0;
  for (const Shared& part : shared) variance += std::pow(part.deviation_px, 2);
  return std::sqrt(variance);
}

double ObservationNoise::MeanLength() const {
  double sum = 0;
  for (const Shared& part : shared)
    sum += part.length * std::pow(part.deviation_px / SharedPx(), 2);
  return sum;
}

ObservationNoise MeasureNoise(const LinearResponse& response,
                              const AdjustmentState& state, int camera,
                              int first, const Eigen::MatrixXd& moves,
                              double noise_px) {
  std::mt19937 random_bits(1);
  const double variance = noise_px * noise_px;
  const ObservationNoise white = {noise_px, noise_px, {}};
  const PairProducts products(response, state.points, camera);
  Influences influences;
  if (moves.rows() == 0 || !influences.Prepare(response, camera, first, moves))
    return white;
  // Draws one kind of noise, and asks for what adjustment leaves of it.
  const auto tell = [&](const ViewErrors& errors) {
    return Told{products.Of(errors), influences.Of(errors)};
  };
  // A draw of many views is a mean over them. All is in units of white noise,
  // so its mean is to be known best.
  const int num_draws =
      std::clamp(1000 / products.num_views(), 2, response.IsExact() ? 16 : 8);
  const int num_white_draws = response.IsExact() ? 4 * num_draws : num_draws;
  const auto told_by = [&](int count, const auto& draw_errors,
                           const auto& draw_gradient) {
    return ToldBy(response, count, tell, draw_errors, draw_gradient);
  };
  const auto no_errors = [&] { return NoErrors(response); };
  const auto no_gradient = [&]() -> Eigen::VectorXd {
    return Eigen::VectorXd::Zero(response.layout().num_all());
  };
  const auto prior = told_by(num_draws, no_errors, [&]() -> Eigen::VectorXd {
    return response.DrawPrior(&random_bits) + response.DrawFlex(&random_bits);
  });
  const auto own = told_by(
      num_white_draws, [&] { return OwnNoise(response, &random_bits); },
      no_gradient);
  if (!prior || !own) return white;
  // Less what the truth's distance from the prior's mean leaves in residuals.
  Told observed = tell(ErrorsOf(response));
  observed.products -= variance * prior->products;
  observed.influence -= variance * prior->influence;
  // Exact features leave nothing but that.
  if (!(observed.products[0] > 0)) return white;

  std::vector<NoiseFit> fits;
  for (const double length : kLengths) {
    const std::vector<SmoothField> fields =
        SmoothFields(response, state.points, length);
    const auto shared = told_by(
        num_draws, [&] { return SharedNoise(fields, &random_bits); },
        no_gradient);
    if (!shared) return white;
    fits.push_back(FitParts(observed, *own, *shared, products.counts()));
  }
  return Mean(fits, noise_px);
}

}  // namespace raygrid
