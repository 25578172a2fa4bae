#include "shutter/timestamp_check.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

namespace raygrid {
namespace {

constexpr size_t kFramesPerSide = 3, kMaxFrames = 8;

// Error of the interval between two frames. If the later frames are shifted
// along the motion by this error, the surrounding frames follow a cubic
// polynomial in time.
struct IntervalError {
  const TimedPose *before = nullptr, *behind = nullptr;
  double seconds = 0;
  double stddev_s = 0;  ///< due to noise, and to motion too fast for sampling
  double sigmas = 0;    ///< per unit standard deviation of the timestamps
};

std::string ToString(const IntervalError& error) {
  const double reported_s = error.behind->time_s - error.before->time_s;
  return fmt::format(
      "from {} to {}: {:.1f} ms, but {:.1f} ms according to the motion",
      error.before->image, error.behind->image, 1e3 * reported_s,
      1e3 * (reported_s + error.seconds));
}

// Coefficients of up to eight frames' pose updates that yield the step and the
// velocity.
struct StepFit {
  Eigen::VectorXd step_weights, velocity_weights;
};

StepFit FitStep(const TimedPose* first, const TimedPose* behind, size_t count) {
  constexpr int kDegree = 3;
  const double center_s = (behind[-1].time_s + behind->time_s) / 2;
  const double timestamp_unit_s = (first[count - 1].time_s - first->time_s) / 2;
  Eigen::MatrixXd terms(static_cast<Eigen::Index>(count), kDegree + 2);
  for (Eigen::Index i = 0; i < terms.rows(); ++i) {
    const double t = (first[i].time_s - center_s) / timestamp_unit_s;
    terms.row(i) << 1, t, t * t, t * t * t, first + i >= behind ? 1 : 0;
  }
  const Eigen::MatrixXd solution =
      (terms.transpose() * terms).ldlt().solve(terms.transpose());
  return {solution.row(kDegree + 1).transpose(),
          solution.row(1).transpose() / timestamp_unit_s};
}

// A discontinuity of the motion relative to the noise of poses: its component
// along the motion, as caused by wrong timestamps, and across it, as caused
// only by noise and fast motion.
struct StepNoises {
  IntervalError error;
  double speed = 0;     // 1/s
  double across = 0;    // mean square over five directions
  double by_noise = 0;  // expected square due to noise
};

std::optional<StepNoises> StepAt(const TimedPose* first,
                                 const TimedPose* behind, size_t count,
                                 double noise_variance_px2) {
  constexpr double kMinSpeedSigmas = 5;
  const StepFit fit = FitStep(first, behind, count);
  Vector6d step = Vector6d::Zero(), velocity = Vector6d::Zero();
  for (size_t i = 0; i < count; ++i) {
    const Vector6d update = ComputeUpdate(behind->pose, first[i].pose);
    step += fit.step_weights[static_cast<Eigen::Index>(i)] * update;
    velocity += fit.velocity_weights[static_cast<Eigen::Index>(i)] * update;
  }
  const Eigen::LLT<Matrix6d> root(behind->information);
  step = root.matrixU() * step;
  velocity = root.matrixU() * velocity;
  StepNoises at;
  at.speed = velocity.norm();
  const double along = step.dot(velocity) / at.speed;
  at.across = std::max(0.0, step.squaredNorm() - along * along) / 5;
  at.by_noise = noise_variance_px2 * fit.step_weights.squaredNorm();
  at.error = {behind - 1, behind, along / at.speed, 0, fit.step_weights.norm()};
  const double speed_noise =
      std::sqrt(noise_variance_px2) * fit.velocity_weights.norm();
  if (!std::isfinite(at.error.seconds) ||
      !(at.speed > kMinSpeedSigmas * speed_noise))
    return std::nullopt;
  return at;
}

// A sequence of consecutive frames without gaps.
struct Run {
  const TimedPose *begin = nullptr, *end = nullptr;

  size_t size() const { return static_cast<size_t>(end - begin); }
};

std::vector<Run> SplitRuns(const TimedTrack& track) {
  std::vector<Run> runs;
  const TimedPose* const end = track.data() + track.size();
  for (const TimedPose *begin = track.data(), *next; begin < end;
       begin = next) {
    for (next = begin + 1;
         next < end && next->time_s - next[-1].time_s <= kMaxFrameGapS;)
      ++next;
    runs.push_back({begin, next});
  }
  return runs;
}

void AddSteps(const Run& run, double noise_variance_px2,
              std::vector<StepNoises>* steps) {
  const size_t size = run.size();
  if (size < 2 * kFramesPerSide) return;
  const size_t count = std::min(kMaxFrames, size);
  for (size_t k = kFramesPerSide; k + kFramesPerSide <= size; ++k) {
    const size_t first = std::min(k - std::min(k, count / 2), size - count);
    if (const auto step =
            StepAt(run.begin + first, run.begin + k, count, noise_variance_px2))
      steps->push_back(*step);
  }
}

// Returns the median of at least one value.
double ComputeMedian(std::vector<double> values) {
  const auto median =
      values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), median, values.end());
  return *median;
}

// Estimates the errors of all intervals whose motion is observable.
std::vector<IntervalError> IntervalErrors(const std::vector<TimedTrack>& tracks,
                                          double noise_variance_px2) {
  // Limits the variance from below, since a single interval may have a small
  // component across the motion by chance.
  constexpr double kTimesMedian = 4;
  std::vector<StepNoises> steps;
  for (const TimedTrack& track : tracks)
    for (const Run& run : SplitRuns(track))
      AddSteps(run, noise_variance_px2, &steps);
  std::vector<double> across;
  for (const StepNoises& step : steps)
    across.push_back(step.across / step.by_noise);
  const double usual =
      across.empty() ? 1 : kTimesMedian * ComputeMedian(across);
  std::vector<IntervalError> errors;
  for (StepNoises& step : steps) {
    const double variance =
        std::max(step.across, step.by_noise * std::max(1.0, usual));
    step.error.stddev_s = std::sqrt(variance) / step.speed;
    errors.push_back(step.error);
  }
  return errors;
}

double MeanInterval(const std::vector<TimedTrack>& tracks) {
  double sum_s = 0, count = 0;
  for (const TimedTrack& track : tracks)
    for (size_t i = 1; i < track.size(); ++i) {
      const double interval_s = track[i].time_s - track[i - 1].time_s;
      if (interval_s > kMaxFrameGapS) continue;
      sum_s += interval_s;
      ++count;
    }
  return count > 0 ? sum_s / count : 0;
}

// Standard deviation of the timestamps: robust, and as RMS including outliers.
struct IntervalScatter {
  double median_s = 0, rms_s = 0;
};

// Estimates the scatter from the intervals with sufficient precision; 0 if
// there are too few of them.
IntervalScatter ComputeScatter(const std::vector<IntervalError>& errors,
                               double interval_s) {
  constexpr double kMaxRelativeStdDev = 0.1, kSigmasPerMedian = 0.6745;
  constexpr size_t kMinErrors = 10;
  std::vector<double> sizes_s;
  double squares = 0;
  for (const IntervalError& error : errors) {
    if (error.stddev_s > kMaxRelativeStdDev * interval_s * error.sigmas)
      continue;
    sizes_s.push_back(std::abs(error.seconds) / error.sigmas);
    squares += (std::pow(error.seconds, 2) - std::pow(error.stddev_s, 2)) /
               std::pow(error.sigmas, 2);
  }
  if (sizes_s.size() < kMinErrors) return {};
  const auto count = static_cast<double>(sizes_s.size());
  return {ComputeMedian(sizes_s) / kSigmasPerMedian,
          std::sqrt(std::max(0.0, squares) / count)};
}

// Finds pauses between sequences across which the motion is discontinuous,
// which indicates a recording in bursts with inconsistent timestamps.
std::string FindBursts(const std::vector<TimedTrack>& tracks,
                       double noise_variance_px2) {
  constexpr double kMaxPauseS = 1, kMinErrorFraction = 0.6, kMinSigmas = 6;
  constexpr size_t kMinErrors = 3;
  std::vector<IntervalError> wrong;
  size_t num_reported = 0;
  for (const TimedTrack& track : tracks) {
    const std::vector<Run> runs = SplitRuns(track);
    for (size_t r = 1; r < runs.size(); ++r) {
      const TimedPose* const behind = runs[r].begin;
      const double pause_s = behind->time_s - behind[-1].time_s;
      const size_t before = std::min(kMaxFrames / 2, runs[r - 1].size());
      const size_t after = std::min(kMaxFrames / 2, runs[r].size());
      if (pause_s > kMaxPauseS || before < kFramesPerSide ||
          after < kFramesPerSide)
        continue;
      auto step =
          StepAt(behind - before, behind, before + after, noise_variance_px2);
      if (!step) continue;
      step->error.stddev_s =
          std::sqrt(std::max(step->across, step->by_noise)) / step->speed;
      if (kMinSigmas * step->error.stddev_s > kMinErrorFraction * pause_s)
        continue;
      ++num_reported;
      if (std::abs(step->error.seconds) > kMinErrorFraction * pause_s)
        wrong.push_back(step->error);
    }
  }
  if (wrong.size() < kMinErrors || 2 * wrong.size() < num_reported) return "";
  return ToString(wrong.front());
}

}  // namespace

std::string CheckTimestamps(const std::vector<TimedTrack>& tracks,
                            double noise_variance_px2) {
  // Limits as fractions of the frame interval. A missing frame amounts to an
  // entire interval; smaller deviations are reported by their standard
  // deviation.
  constexpr double kMinErrorFraction = 0.6, kRelativeScatter = 0.15;
  constexpr double kMinSigmas = 6, kMinScatterRatio = 4.5;
  const double interval_s = MeanInterval(tracks);
  const std::vector<IntervalError> errors =
      IntervalErrors(tracks, noise_variance_px2);
  const IntervalScatter scatter = ComputeScatter(errors, interval_s);
  const IntervalError* worst = nullptr;
  for (const IntervalError& error : errors) {
    const double size_s = std::abs(error.seconds);
    if (size_s > kMinErrorFraction * interval_s &&
        size_s > kMinSigmas * error.stddev_s &&
        size_s > kMinScatterRatio * error.sigmas * scatter.median_s &&
        (!worst || size_s > std::abs(worst->seconds)))
      worst = &error;
  }
  if (worst) return ToString(*worst);
  if (scatter.rms_s > kRelativeScatter * interval_s)
    return fmt::format("jitter of {:.1f} ms at a frame interval of {:.1f} ms",
                       1e3 * scatter.rms_s, 1e3 * interval_s);
  return FindBursts(tracks, noise_variance_px2);
}

}  // namespace raygrid
