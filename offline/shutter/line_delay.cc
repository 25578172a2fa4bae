#include "shutter/line_delay.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "shutter/frame_equations.h"
#include "shutter/timestamp_check.h"

namespace raygrid {
namespace {

// Prior standard deviations of the coefficients of camera bias (px) and board
// deformation (fraction of half the board's size): weakly informative.
constexpr double kImageCurvaturePx = 10, kBoardDeformationFraction = 0.02;

// A frame for which the motion can be estimated.
struct MovingFrame {
  const MotionStencil* stencil = nullptr;
  FrameMotion motion;
  FrameEquations equations;
  double information = 0;  // on the line delay, after eliminating biases

  // Frames at the ends of sequences have a motion estimate that is sufficient
  // to correct their poses, but do not contribute to the line delay.
  bool IsObservable() const { return stencil->IsCentral(); }
};

struct MovingBoard {
  BoardTrack track;
  std::vector<MovingFrame> frames;
};

// Line-delay estimate from one of several consecutive groups of frames.
struct GroupEstimate {
  double seconds = 0, stddev_s = 0;
};

// Information of a frame on the line delay, and its gradient.
struct FrameGradient {
  double information = 0, gradient = 0;
};

// Returns the line delay of some frames relative to that of all frames.
GroupEstimate EstimateGroup(const std::vector<FrameGradient>& frames,
                            double noise_variance) {
  double information = 0, gradient = 0, squares = 0;
  for (const FrameGradient& frame : frames) {
    information += frame.information;
    gradient += frame.gradient;
  }
  const double change_s = -gradient / information;
  for (const FrameGradient& frame : frames)
    squares += std::pow(frame.gradient + change_s * frame.information, 2);
  return {change_s, std::sqrt(std::max(squares, noise_variance * information)) /
                        information};
}

// Returns the information-weighted mean; infinite standard deviation if there
// are no estimates.
GroupEstimate ComputeWeightedMean(const std::vector<GroupEstimate>& parts) {
  double information = 0, sum = 0;
  for (const GroupEstimate& part : parts) {
    const double own = 1 / (part.stddev_s * part.stddev_s);
    information += own;
    sum += own * part.seconds;
  }
  return {sum / information, 1 / std::sqrt(information)};
}

std::string FormatMicroseconds(double seconds) {
  return fmt::format("{:.3g} us", seconds * 1e6);
}

class LineDelayOptimization {
 public:
  explicit LineDelayOptimization(const MovingViews& views);

  // Performs Gauss-Newton steps over poses and shared parameters. The line
  // delay is fixed if it is given.
  void OptimizeCameras(std::optional<double> line_delay_s);

  // Recomputes the noise variance after convergence, with the estimated camera
  // bias and board deformation and with fixed motions.
  void EstimateDeformation();

  LineDelayEstimate Result(int num_images) const;

  const std::vector<MovingBoard>& boards() const { return boards_; }

 private:
  // Normal equations of the shared parameters, and the cost in px^2.
  struct Sums {
    Eigen::MatrixXd information;
    Eigen::VectorXd gradient;
    double squares = 0;
    int64_t degrees_of_freedom = 0;

    // Returns the noise variance at the optimal poses and shared parameters.
    double NoiseVariance() const {
      const double explained = gradient.dot(information.ldlt().solve(gradient));
      return (squares - explained) /
             static_cast<double>(std::max<int64_t>(1, degrees_of_freedom));
    }
  };

  double ComputeNoiseStdDev() const {
    return std::sqrt(noise_variance_ * covariance_(0, 0));
  }
  // Extracts the shared parameters that affect a board from all shared
  // parameters.
  SharedVector SelectShared(size_t board, const Eigen::VectorXd& all) const;
  void AddShared(size_t board, const SharedVector& own,
                 Eigen::VectorXd* all) const;
  void AddShared(size_t board, const SharedMatrix& own,
                 Eigen::MatrixXd* all) const;
  double ComputeNoiseShare(const MovingBoard& board, const MovingFrame& frame,
                           const Eigen::Matrix<double, 5, 1>& weights) const;
  std::vector<TimedTrack> TimedTracks() const;
  std::vector<GroupEstimate> EstimateInGroups() const;
  std::string DescribeInconsistentGroups() const;
  void UpdatePoses();
  Sums Linearize(const Eigen::VectorXd& shared);
  void RemoveNoise(Sums* sums);
  void MovePoses(const Eigen::VectorXd& change);
  double Step();
  double ComputeFrameVariance() const;
  double EstimateFastMotionBias() const;
  double TimeVariance() const;
  double EstimateTimestampBias() const;

  const CameraModel& camera_;
  const Dataset& dataset_;
  const bool is_rolling_shutter_compensated_;
  ImageSize size_;
  std::vector<MovingBoard> boards_;
  Eigen::Index count_ = 0;  // shared parameters: common and per board
  bool is_line_delay_fixed_ = false;
  double line_delay_s_ = 0;
  Eigen::VectorXd deformations_;
  Eigen::MatrixXd covariance_;  // for noise of 1 px
  double noise_variance_ = 0;
  double noise_share_ = 0;  // fraction of the information on the line delay
};

LineDelayOptimization::LineDelayOptimization(const MovingViews& views)
    : camera_(*views.camera),
      dataset_(*views.dataset),
      is_rolling_shutter_compensated_(views.is_rolling_shutter_compensated),
      size_(views.camera->image_size()) {
  for (BoardTrack& track : MakeTracks(views)) {
    MovingBoard& board = boards_.emplace_back();
    board.track = std::move(track);
    for (const MotionStencil& stencil : board.track.stencils)
      board.frames.emplace_back().stencil = &stencil;
  }
  count_ = static_cast<Eigen::Index>(kNumFrameParameters +
                                     kNumBoardParameters * boards_.size());
  deformations_.setZero(count_);
  covariance_.setZero(count_, count_);
}

SharedVector LineDelayOptimization::SelectShared(
    size_t board, const Eigen::VectorXd& all) const {
  SharedVector own;
  own << all.head<kNumFrameParameters>(),
      all.segment<kNumBoardParameters>(static_cast<Eigen::Index>(
          kNumFrameParameters + board * kNumBoardParameters));
  return own;
}

void LineDelayOptimization::AddShared(size_t board, const SharedVector& own,
                                      Eigen::VectorXd* all) const {
  all->head<kNumFrameParameters>() += own.head<kNumFrameParameters>();
  all->segment<kNumBoardParameters>(static_cast<Eigen::Index>(
      kNumFrameParameters + board * kNumBoardParameters)) +=
      own.tail<kNumBoardParameters>();
}

void LineDelayOptimization::AddShared(size_t board, const SharedMatrix& own,
                                      Eigen::MatrixXd* all) const {
  const auto at = static_cast<Eigen::Index>(kNumFrameParameters +
                                            board * kNumBoardParameters);
  all->topLeftCorner<kNumFrameParameters, kNumFrameParameters>() +=
      own.topLeftCorner<kNumFrameParameters, kNumFrameParameters>();
  all->block<kNumBoardParameters, kNumBoardParameters>(at, at) +=
      own.bottomRightCorner<kNumBoardParameters, kNumBoardParameters>();
  all->block<kNumFrameParameters, kNumBoardParameters>(0, at) +=
      own.topRightCorner<kNumFrameParameters, kNumBoardParameters>();
  all->block<kNumBoardParameters, kNumFrameParameters>(at, 0) +=
      own.bottomLeftCorner<kNumBoardParameters, kNumFrameParameters>();
}

void LineDelayOptimization::OptimizeCameras(
    std::optional<double> line_delay_s) {
  constexpr int kMaxSteps = 20;
  is_line_delay_fixed_ = line_delay_s.has_value();
  line_delay_s_ = line_delay_s.value_or(0);
  for (int step = 0; step < kMaxSteps; ++step) {
    const double change_s = Step();
    // Motions are computed from the poses of the previous step, so the first
    // steps cannot indicate convergence.
    if (step > 1 && !(std::abs(change_s) > 1e-3 * ComputeNoiseStdDev())) break;
  }
}

// Returns the spurious information on the line delay, for noise of 1 px. The
// velocity is a weighted sum of noisy poses and enters squared, so that noise
// is mistaken for motion.
double LineDelayOptimization::ComputeNoiseShare(
    const MovingBoard& board, const MovingFrame& frame,
    const Eigen::Matrix<double, 5, 1>& weights) const {
  const Matrix6d information = frame.equations.VelocityInformation();
  double part = 0;
  for (const MovingFrame& other : board.frames) {
    const int j = other.stencil->frame - frame.stencil->first;
    if (j < 0 || j > 4) continue;
    part += weights[j] * weights[j] *
            (other.equations.pose_covariance * information).trace();
  }
  return part;
}

void LineDelayOptimization::UpdatePoses() {
  for (MovingBoard& board : boards_)
    for (MovingFrame& frame : board.frames)
      frame.motion = ComputeMotion(*frame.stencil, board.track.poses);
}

// Linearizes the residuals of all frames at their poses and motions.
LineDelayOptimization::Sums LineDelayOptimization::Linearize(
    const Eigen::VectorXd& shared) {
  Sums sums = {Eigen::MatrixXd::Zero(count_, count_),
               Eigen::VectorXd::Zero(count_), 0, -count_};
  for (size_t b = 0; b < boards_.size(); ++b) {
    const BoardTrack& track = boards_[b].track;
    SharedMatrix own = SharedMatrix::Zero(), unused = own;
    const SharedVector along = SelectShared(b, covariance_.row(0));
    for (MovingFrame& frame : boards_[b].frames) {
      const int index = frame.stencil->frame;
      const double before = along.dot(own * along);
      frame.equations = MakeFrameEquations(
          {&camera_, &track.points[index], track.poses[index], frame.motion,
           track.half_m, SelectShared(b, shared)},
          frame.IsObservable() ? &own : &unused);
      if (!frame.IsObservable()) continue;
      frame.information = (along.dot(own * along) - before) /
                          (covariance_(0, 0) * covariance_(0, 0));
      AddShared(b, frame.equations.gradient, &sums.gradient);
      sums.squares += frame.equations.squares;
      sums.degrees_of_freedom += 2 * frame.equations.num_points - 6;
    }
    AddShared(b, own, &sums.information);
  }
  for (Eigen::Index k = 1; k < count_; ++k) {
    const double deviation =
        k < kNumFrameParameters ? kImageCurvaturePx : kBoardDeformationFraction;
    sums.information(k, k) += 1 / (deviation * deviation);
    sums.gradient[k] += shared[k] / (deviation * deviation);
  }
  return sums;
}

// Subtracts the spurious information due to noise, limited to half of the
// total; if the limit is exceeded, noise dominates the estimate.
void LineDelayOptimization::RemoveNoise(Sums* sums) {
  double noise = 0, motion = 0;
  for (const MovingBoard& board : boards_)
    for (const MovingFrame& frame : board.frames) {
      if (!frame.IsObservable()) continue;
      noise +=
          noise_variance_ *
          ComputeNoiseShare(board, frame, frame.stencil->velocity_coefficients);
      const Vector6d& velocity = frame.motion.velocity;
      motion += velocity.dot(frame.equations.VelocityInformation() * velocity);
    }
  const double variance =
      sums->information.ldlt().solve(Eigen::VectorXd::Unit(count_, 0))[0];
  // Larger fraction of two: after eliminating biases, or of the total
  // information without accelerations.
  noise_share_ = std::max(noise * variance, noise / motion);
  noise = std::min(noise, 0.5 / variance);
  sums->information(0, 0) -= noise;
  sums->gradient[0] -= noise * line_delay_s_;
}

void LineDelayOptimization::MovePoses(const Eigen::VectorXd& change) {
  for (size_t b = 0; b < boards_.size(); ++b)
    for (MovingFrame& frame : boards_[b].frames) {
      const Vector6d step = frame.equations.PoseStep(SelectShared(b, change));
      Pose& pose = boards_[b].track.poses[frame.stencil->frame];
      if (step.allFinite()) pose = UpdatedPose(pose, step);
    }
}

// Performs a Gauss-Newton step, and returns the change of the line delay. Poses
// are not updated for the biases: otherwise, the motions would depend on the
// noise of all frames along almost unobservable biases of camera and board.
double LineDelayOptimization::Step() {
  const Eigen::VectorXd line_delay = Eigen::VectorXd::Unit(count_, 0);
  UpdatePoses();
  Sums sums = Linearize(line_delay_s_ * line_delay);
  noise_variance_ = sums.NoiseVariance();
  RemoveNoise(&sums);
  if (is_line_delay_fixed_) {
    sums.information.row(0).setZero();
    sums.information.col(0).setZero();
    sums.information(0, 0) = 1;
    sums.gradient[0] = 0;
  }
  covariance_ =
      sums.information.ldlt().solve(Eigen::MatrixXd::Identity(count_, count_));
  deformations_ = -covariance_ * sums.gradient;
  if (!deformations_.allFinite()) return 0;
  const double change_s = deformations_[0];
  deformations_[0] = 0;
  line_delay_s_ += change_s;
  MovePoses(change_s * line_delay);
  return change_s;
}

void LineDelayOptimization::EstimateDeformation() {
  const Eigen::VectorXd line_delay =
      line_delay_s_ * Eigen::VectorXd::Unit(count_, 0);
  UpdatePoses();
  Linearize(line_delay);
  MovePoses(deformations_);
  noise_variance_ = Linearize(line_delay + deformations_).NoiseVariance();
}

// Returns the empirical variance of the line delay from the gradients of single
// frames. Includes errors that are common to the features of a frame, and
// errors of velocities.
double LineDelayOptimization::ComputeFrameVariance() const {
  double sum = 0, count = 0;
  for (size_t b = 0; b < boards_.size(); ++b)
    for (const MovingFrame& frame : boards_[b].frames) {
      if (!frame.IsObservable()) continue;
      const double pull =
          SelectShared(b, covariance_.row(0)).dot(frame.equations.gradient);
      sum += pull * pull;
      ++count;
    }
  return count > 1 ? sum * count / (count - 1) : 0;
}

// Relative bias of the line delay due to fast motion, which finite differences
// underestimate. A motion of frequency f is underestimated by u = (2 pi f T)^2
// / 6 with two neighbours, and by 1.2 u^2 with four, so that u and the bias
// follow from the difference of both velocities.
double LineDelayOptimization::EstimateFastMotionBias() const {
  double difference = 0, all = 0;
  for (const MovingBoard& board : boards_)
    for (const MovingFrame& frame : board.frames) {
      if (!frame.IsObservable()) continue;
      const Matrix6d& weight = frame.equations.by_row2;
      const Vector6d& fine = frame.motion.velocity;
      const Vector6d coarse = fine - frame.motion.coarse_velocity;
      difference += coarse.dot(weight * coarse);
      all += fine.dot(weight * fine);
    }
  return all > 0 ? 1.2 * difference / all : 0;
}

// Returns the variance of the timestamps in s^2: the deviation from smooth
// motion in excess of the noise of poses. Includes motion that is too fast for
// the frame rate.
double LineDelayOptimization::TimeVariance() const {
  double uneven = 0, all = 0;
  for (const MovingBoard& board : boards_)
    for (const MovingFrame& frame : board.frames) {
      if (!frame.IsObservable()) continue;
      const Matrix6d weight = frame.equations.VelocityInformation();
      const FrameMotion& motion = frame.motion;
      uneven += motion.unevenness.dot(weight * motion.unevenness) -
                noise_variance_ *
                    ComputeNoiseShare(board, frame,
                                      frame.stencil->unevenness_coefficients);
      all += motion.velocity.dot(weight * motion.velocity);
    }
  return all > 0 ? std::max(0.0, uneven / all) : 0;
}

// Relative bias of the line delay due to timestamp noise. The noise causes
// velocity errors, and thus spurious motion like the noise of poses. It also
// increases velocities by the same fraction, since they are quotients of noisy
// values.
double LineDelayOptimization::EstimateTimestampBias() const {
  double pretended = 0;
  for (const MovingBoard& board : boards_)
    for (const MovingFrame& frame : board.frames)
      if (frame.IsObservable())
        pretended +=
            frame.stencil->velocity_coefficients.squaredNorm() *
            frame.motion.velocity.dot(frame.equations.VelocityInformation() *
                                      frame.motion.velocity);
  return 2 * TimeVariance() * pretended * covariance_(0, 0);
}

// Returns the maximum line delay: the readout time of a frame cannot exceed the
// shortest frame interval.
double MaxLineDelay(const std::vector<MovingBoard>& boards, int height) {
  constexpr double kUsualIntervalS = 1 / 30.0;
  double min_interval_s = kUsualIntervalS;
  for (const MovingBoard& board : boards)
    for (const MovingFrame& frame : board.frames)
      if (frame.IsObservable())
        min_interval_s = std::min(
            min_interval_s, board.track.times_s[frame.stencil->frame] -
                                board.track.times_s[frame.stencil->frame - 1]);
  return min_interval_s / height;
}

std::vector<TimedTrack> LineDelayOptimization::TimedTracks() const {
  std::vector<TimedTrack> tracks;
  for (const MovingBoard& board : boards_) {
    TimedTrack& track = tracks.emplace_back();
    for (const MovingFrame& frame : board.frames) {
      const int index = frame.stencil->frame;
      const auto& points = board.track.points[index];
      track.push_back(
          {points.empty() ? "" : dataset_.images[points[0].image].image,
           board.track.times_s[index], board.track.poses[index],
           frame.equations.pose});
    }
  }
  return tracks;
}

// Divides the frames into consecutive groups with similar information. The line
// delay of each group follows from its gradient, with the biases of all frames.
std::vector<GroupEstimate> LineDelayOptimization::EstimateInGroups() const {
  constexpr int kNumGroups = 6;
  std::multimap<double, FrameGradient> gradients_by_time;
  double all = 0;
  for (size_t b = 0; b < boards_.size(); ++b) {
    const SharedVector along =
        SelectShared(b, covariance_.row(0)) / covariance_(0, 0);
    for (const MovingFrame& frame : boards_[b].frames) {
      if (!frame.IsObservable()) continue;
      gradients_by_time.insert(
          {boards_[b].track.times_s[frame.stencil->frame],
           {frame.information, along.dot(frame.equations.gradient)}});
      all += frame.information;
    }
  }
  std::vector<GroupEstimate> parts;
  std::vector<FrameGradient> part;
  double before = 0;
  for (const auto& [time_s, frame] : gradients_by_time) {
    part.push_back(frame);
    before += frame.information;
    const auto num_parts = static_cast<double>(parts.size() + 1);
    if (before < all * num_parts / kNumGroups * (1 - 1e-9)) continue;
    parts.push_back(EstimateGroup(part, noise_variance_));
    parts.back().seconds += line_delay_s_;
    part.clear();
  }
  return parts;
}

// Finds a time at which the line delay changes significantly during the
// recording, for example due to a varying clock rate. Returns an empty string
// if there is none.
std::string LineDelayOptimization::DescribeInconsistentGroups() const {
  constexpr double kMinInconsistencySigmas = 5, kMatters = 0.1;
  std::string found;
  double largest = kMinInconsistencySigmas;
  const std::vector<GroupEstimate> parts = EstimateInGroups();
  for (auto split = parts.begin(); split != parts.end(); ++split) {
    const GroupEstimate before = ComputeWeightedMean({parts.begin(), split}),
                        after = ComputeWeightedMean({split, parts.end()});
    const double difference_s = std::abs(after.seconds - before.seconds);
    const double sigmas =
        difference_s / std::hypot(before.stddev_s, after.stddev_s);
    if (!(sigmas > largest) ||
        difference_s <= kMatters * std::abs(line_delay_s_))
      continue;
    largest = sigmas;
    found = fmt::format(
        "line delay {} ± {} in the earlier frames, {} ± {} in the later frames",
        FormatMicroseconds(before.seconds), FormatMicroseconds(before.stddev_s),
        FormatMicroseconds(after.seconds), FormatMicroseconds(after.stddev_s));
  }
  return found;
}

LineDelayEstimate LineDelayOptimization::Result(int num_images) const {
  // Smaller fractions of the maximum are irrelevant.
  constexpr double kMinIndependentPart = 0.05;
  LineDelayEstimate result;
  result.num_images = num_images;
  result.value.seconds = line_delay_s_;
  const double bias_s =
      std::hypot(EstimateFastMotionBias(), EstimateTimestampBias()) *
      line_delay_s_;
  const double variance = std::max(ComputeFrameVariance(),
                                   ComputeNoiseStdDev() * ComputeNoiseStdDev());
  result.value.stddev_s = std::sqrt(variance + bias_s * bias_s);
  const double max_delay_s = MaxLineDelay(boards_, size_.height);
  const double limit_s = kMinIndependentPart * max_delay_s;
  const bool moves = std::isfinite(result.value.seconds) &&
                     std::isfinite(result.value.stddev_s) &&
                     noise_share_ <= 0.5;
  std::string wrong = CheckTimestamps(TimedTracks(), noise_variance_);
  if (wrong.empty() && moves && is_rolling_shutter_compensated_)
    wrong = DescribeInconsistentGroups();
  result.are_timestamps_consistent = wrong.empty();
  if (!wrong.empty())
    result.unobservable_reason = fmt::format(
        "the timestamps are inconsistent with the motion ({}): frames were "
        "delivered in bursts, lost or reordered, or the frame rate changed; "
        "use the sensor's timestamps",
        wrong);
  else if (!moves)
    result.unobservable_reason =
        "too little motion between frames; move and rotate the camera or the "
        "target while recording";
  else if (result.value.stddev_s > limit_s && std::abs(bias_s) > limit_s / 2)
    result.unobservable_reason = fmt::format(
        "motion is too fast for the frame rate, or timestamps are noisy (±{}); "
        "use the sensor's timestamps, move more slowly, or increase the frame "
        "rate",
        FormatMicroseconds(result.value.stddev_s));
  else if (result.value.stddev_s > limit_s)
    result.unobservable_reason = fmt::format(
        "its standard deviation of {} exceeds {} ({:g} % of the largest line "
        "delay possible at this frame rate); record more frames, with more "
        "motion and rotation in all directions",
        FormatMicroseconds(result.value.stddev_s), FormatMicroseconds(limit_s),
        100 * kMinIndependentPart);
  else if (std::abs(result.value.seconds) > max_delay_s + 2 * limit_s)
    result.unobservable_reason = fmt::format(
        "the estimate of {} exceeds the {} possible at this frame rate; check "
        "that the timestamps belong to these images, in seconds",
        FormatMicroseconds(result.value.seconds),
        FormatMicroseconds(max_delay_s));
  return result;
}

// Returns the number of images used, which have two neighbours on either side.
int CountImages(const std::vector<MovingBoard>& boards) {
  std::set<size_t> images;
  for (const MovingBoard& board : boards)
    for (const MovingFrame& frame : board.frames) {
      const auto& points = board.track.points[frame.stencil->frame];
      if (frame.IsObservable() && !points.empty())
        images.insert(points.front().image);
    }
  return static_cast<int>(images.size());
}

// Returns the displacement from the observed position to the position at the
// readout time of the middle row; zero if it cannot be computed.
Eigen::Vector2d ComputePointMotion(const CameraModel& camera,
                                   const MovingBoard& board,
                                   const MovingFrame& frame,
                                   const TrackPoint& point,
                                   double line_delay_s) {
  const Pose& pose = board.track.poses[frame.stencil->frame];
  const double seconds =
      line_delay_s * (point.pixel.y() - GetReferenceRow(camera.image_size()));
  const Pose then = frame.motion.PoseAfter(seconds, pose);
  const auto moving =
      camera.Project(then * point.point, &point.pixel, kShutterMarginPx);
  const auto at_once =
      camera.Project(pose * point.point, &point.pixel, kShutterMarginPx);
  return moving && at_once ? Eigen::Vector2d(*at_once - *moving)
                           : Eigen::Vector2d(0, 0);
}

}  // namespace

LineDelayEstimate EstimateLineDelay(const MovingViews& views) {
  constexpr int kMinImages = 20;
  LineDelayOptimization adjustment(views);
  const int num_images = CountImages(adjustment.boards());
  if (num_images < kMinImages) {
    LineDelayEstimate none;
    none.num_images = num_images;
    none.unobservable_reason = fmt::format(
        "only {} images have two adjacent frames on either side, each within "
        "{:g} s; at least {} are required; check that times are in seconds, "
        "and record consecutive frames of a moving camera",
        num_images, kMaxFrameGapS, kMinImages);
    return none;
  }
  adjustment.OptimizeCameras(std::nullopt);
  adjustment.EstimateDeformation();
  return adjustment.Result(num_images);
}

Dataset ComputeGlobalShutterFeatures(const MovingViews& views,
                                     double line_delay_s) {
  LineDelayOptimization adjustment(views);
  adjustment.OptimizeCameras(line_delay_s);
  Dataset still = *views.dataset;
  for (ImageFeatures& seen : still.images) seen.features.clear();
  const Area image = WholeImage(views.camera->image_size());
  for (const MovingBoard& board : adjustment.boards())
    for (const MovingFrame& frame : board.frames)
      for (const TrackPoint& point : board.track.points[frame.stencil->frame]) {
        Feature feature =
            views.dataset->images[point.image].features[point.feature];
        feature.pixel += ComputePointMotion(*views.camera, board, frame, point,
                                            line_delay_s);
        if (image.Contains(feature.pixel))
          still.images[point.image].features.push_back(feature);
      }
  return still;
}

}  // namespace raygrid
