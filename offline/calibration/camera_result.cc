#include "calibration/camera_result.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "calibration/camera_check.h"
#include "calibration/cross_validation.h"
#include "calibration/even_selection.h"
#include "calibration/near_duplicates.h"
#include "calibration/uncertainty_estimation.h"
#include "evaluation/prediction_comparison.h"

namespace raygrid {
namespace {

Dataset UsedFeatures(const Pattern& pattern, const CalibrationProblem& problem,
                     int camera) {
  Dataset used;
  used.image_size = problem.image_sizes[camera];
  for (size_t v = 0; v < problem.views.size(); ++v) {
    if (problem.views[v].camera != camera) continue;
    if (used.images.empty() || used.images.back().image != problem.images[v])
      used.images.push_back({problem.images[v], {}});
    for (const Observation& observation : problem.views[v].observations)
      used.images.back().features.push_back(
          problem.GetFeature(pattern, static_cast<int>(v), observation));
  }
  return used;
}

std::optional<BoardDeformation> GetDeformation(const Pattern& pattern,
                                               const AdjustmentResult& adjusted,
                                               int camera) {
  const AdjustmentState& state = adjusted.state;
  const CalibrationProblem& problem = adjusted.problem;
  if (!state.HasPerViewDeformation()) return std::nullopt;
  BoardDeformation bends;
  int most_deformed = -1;  // view of the problem
  double square = 0;
  for (size_t v = 0; v < problem.views.size(); ++v) {
    const View& view = problem.views[v];
    if (view.camera != camera) continue;
    // The modes are orthogonal, and each has a mean square of 1.
    const double rms_m = state.flex[view.pose].norm();
    square += rms_m * rms_m;
    if (most_deformed < 0 || rms_m > bends.views[bends.most_deformed].rms_m) {
      most_deformed = static_cast<int>(v);
      bends.most_deformed = static_cast<int>(bends.views.size());
    }
    bends.views.push_back(
        {problem.images[v], pattern.boards[problem.boards[v]].id, rms_m});
  }
  if (most_deformed < 0) return std::nullopt;
  bends.rms_m = std::sqrt(square / static_cast<double>(bends.views.size()));
  const int board = problem.boards[most_deformed];
  const int first = problem.first_points[board];
  const DeformationModes::Coefficients& flex =
      state.flex[problem.views[most_deformed].pose];
  for (int i = first; i < first + pattern.boards[board].num_points(); ++i) {
    const Eigen::Vector3d moved = state.modes.by_point[i] * flex;
    bends.heights_m.push_back(moved.z() < 0 ? -moved.norm() : moved.norm());
  }
  return bends;
}

// Returns the normal of a flat board; nullopt for a point set that is not
// planar.
std::optional<Eigen::Vector3d> ComputeNormal(const Board& board) {
  constexpr double kMaxFlatExtentRatio =
      0.02;  // fraction of the board's extent
  if (!board.IsPointSet()) return Eigen::Vector3d::UnitZ();
  Eigen::Matrix3Xd points(3, board.points.size());
  for (size_t i = 0; i < board.points.size(); ++i)
    points.col(static_cast<Eigen::Index>(i)) = board.points[i];
  points.colwise() -= points.rowwise().mean().eval();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(
      points * points.transpose());
  const Eigen::Vector3d extents = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  if (extents[0] > kMaxFlatExtentRatio * extents[2]) return std::nullopt;
  return solver.eigenvectors().col(0);
}

// Returns the normals of all observed boards in camera coordinates.
std::vector<Eigen::Vector3d> CollectBoardNormals(
    const CalibrationResult& result) {
  std::map<int, std::optional<Eigen::Vector3d>> normals;
  for (const Board& board : result.pattern.boards)
    normals[board.id] = ComputeNormal(board);
  std::vector<Eigen::Vector3d> seen;
  for (const BoardPose& pose : result.poses)
    if (const auto& normal = normals.at(pose.board))
      seen.push_back(pose.camera_from_board.rotation * *normal);
  return seen;
}

// Returns the largest angle between the planes of two observed boards.
double ComputeTilt(const std::vector<Eigen::Vector3d>& normals) {
  double min_cosine = 1;
  for (const Eigen::Vector3d& a : normals)
    for (const Eigen::Vector3d& b : normals)
      min_cosine = std::min(min_cosine, std::abs(a.dot(b)));
  return std::acos(min_cosine);
}

// Point sets have no front side.
bool HasSides(const Board& board) { return !board.IsPointSet(); }

bool IsBoardFacingAway(const BoardPose& seen, const Board& board) {
  const Eigen::Vector3d into_page =
      seen.camera_from_board.rotation * Eigen::Vector3d::UnitZ();
  return into_page.dot(seen.camera_from_board *
                       board.points[board.num_points() / 2]) < 0;
}

void AddSides(const CalibrationResult& result, CalibrationMetrics* metrics) {
  for (const BoardPose& seen : result.poses) {
    const Board& board = *result.pattern.FindBoard(seen.board);
    if (!HasSides(board)) continue;
    ++metrics->boards_seen;
    if (IsBoardFacingAway(seen, board))
      metrics->mirrored_images.push_back(seen.image);
  }
}

// A view of a board with all its detected features, including rejected ones.
struct ObservedBoard {
  const BoardPose* pose;
  std::map<std::pair<int, int>, Eigen::Vector2d> pixels;  // by column, row
};

std::vector<ObservedBoard> CollectObservedBoards(
    const CalibrationResult& result) {
  std::map<std::pair<std::string, int>, ObservedBoard> boards;
  const auto add = [&](const std::string& image, const Feature& feature) {
    boards[{image, feature.board}].pixels[{feature.column, feature.row}] =
        feature.pixel;
  };
  for (const ImageFeatures& image : result.features.images)
    for (const Feature& feature : image.features) add(image.image, feature);
  for (const FeatureResidual& f : result.rejected_features)
    add(f.image, {f.board, f.column, f.row, f.pixel});
  std::vector<ObservedBoard> seen;
  for (const BoardPose& pose : result.poses)
    seen.push_back({&pose, boards[{pose.image, pose.board}].pixels});
  return seen;
}

bool IsSamePose(const Pose& a, const Pose& b) {
  constexpr double kMaxRotationRad = 2 * M_PI / 180,
                   kMaxRelativeDifference = 0.02;
  return a.rotation.angularDistance(b.rotation) < kMaxRotationRad &&
         (a.translation - b.translation).norm() <
             kMaxRelativeDifference * b.translation.norm();
}

// Whether a board has the same pose in two images, decided by pixel positions:
// if all images are near-duplicates, poses are not observable.
bool HaveSamePose(const ObservedBoard& a, const ObservedBoard& b,
                  const ImageSize& size) {
  constexpr double kMaxRelativeDifference = 0.005;
  const double max_difference_px =
      kMaxRelativeDifference * std::max(size.width, size.height);
  bool have_common = false;
  for (const auto& [place, pixel] : a.pixels) {
    const auto other = b.pixels.find(place);
    if (other == b.pixels.end()) continue;
    if ((other->second - pixel).norm() > max_difference_px) return false;
    have_common = true;
  }
  return have_common;
}

// Counts the board views that differ from all previous views.
int CountDistinctPoses(const CalibrationResult& result) {
  std::vector<ObservedBoard> different;
  for (const ObservedBoard& seen : CollectObservedBoards(result)) {
    const auto is_indistinguishable = [&](const ObservedBoard& before) {
      return before.pose->board == seen.pose->board &&
             (IsSamePose(before.pose->camera_from_board,
                         seen.pose->camera_from_board) ||
              HaveSamePose(before, seen, result.features.image_size));
    };
    if (std::none_of(different.begin(), different.end(), is_indistinguishable))
      different.push_back(seen);
  }
  return static_cast<int>(different.size());
}

const std::vector<FeatureResidual>& GetAssessedResiduals(
    const CalibrationResult& result) {
  return result.held_out.empty() ? result.training : result.held_out;
}

std::vector<FeatureResidual> FilterOutImages(
    std::vector<FeatureResidual> residuals,
    const std::set<std::string>& images) {
  residuals.erase(
      std::remove_if(residuals.begin(), residuals.end(),
                     [&](const auto& r) { return images.count(r.image) > 0; }),
      residuals.end());
  return residuals;
}

// Returns the correlation of neighbouring errors, excluding the contribution of
// the camera's uncertainty. A camera that is calibrated from few images has
// smooth errors; they appear in its predictions, but not in its training
// residuals.
std::optional<double> ComputeSharedCorrelation(
    const CalibrationResult& result, const std::set<std::string>& outlying) {
  const auto held_out = ComputeNeighborCorrelation(
      FilterOutImages(GetAssessedResiduals(result), outlying));
  const auto training =
      ComputeNeighborCorrelation(FilterOutImages(result.training, outlying));
  if (!held_out || !training) return held_out;
  return std::min(*held_out, *training);
}

bool HasLowerHeldOutError(const ModelMetrics& other,
                          const CalibrationResult& result) {
  return ComparePredictions(result.held_out, other.held_out_residuals)
             .NameBetterCamera() == std::string("second");
}

// Describes a position as one of nine image regions.
std::string DescribePositionInImage(const Eigen::Vector2d& pixel,
                                    const ImageSize& size) {
  const auto third = [](double at, int extent) {
    return std::clamp(static_cast<int>(3 * at / extent), 0, 2);
  };
  const int column = third(pixel.x(), size.width);
  const int row = third(pixel.y(), size.height);
  const std::array<std::string, 3> rows = {"top", "middle", "bottom"};
  if (column == 1) return rows[row];
  const std::string side = column == 0 ? "left" : "right";
  return row == 1 ? side : rows[row] + " " + side;
}

// Finds images with more outliers than chance or a few corners at the edge of
// the board explain.
void FindMisreadImages(const CalibrationResult& result,
                       CalibrationMetrics* metrics) {
  constexpr int kLeast = 5;
  constexpr double kMinFraction = 0.15;
  std::map<std::string, int> num_kept, num_rejected;
  for (const FeatureResidual& r : result.training) ++num_kept[r.image];
  for (const FeatureResidual& r : result.rejected_features)
    ++num_rejected[r.image];
  for (const auto& [image, count] : num_rejected) {
    const int num_features = num_kept[image] + count;
    if (count < kLeast || num_kept[image] == 0 ||
        count < kMinFraction * num_features)
      continue;
    ++metrics->num_misread_images;
    if (count > metrics->most_misread.num_rejected)
      metrics->most_misread = {image, count, num_features};
  }
}

// Separates images with unique coverage from outlier images, and finds the
// image regions that contain most of their largest errors.
void SeparateOutlierImages(const CalibrationResult& result,
                           const std::set<std::string>& outlying,
                           CalibrationMetrics* metrics) {
  constexpr double kWorst = 0.75;
  metrics->unique_coverage_images = result.unique_coverage_images;
  std::set<std::string> alone(result.unique_coverage_images.begin(),
                              result.unique_coverage_images.end());
  for (const std::string& image : outlying)
    if (alone.count(image) == 0) metrics->outlier_images.push_back(image);
  std::set<std::string> places;
  for (const std::string& image : alone) {
    std::vector<double> norms;
    for (const FeatureResidual& r : result.held_out)
      if (r.image == image) norms.push_back(r.error_px.norm());
    const double worst_px = Quantile(norms, kWorst);
    std::map<std::string, int> counts;
    for (const FeatureResidual& r : result.held_out)
      if (r.image == image && r.error_px.norm() >= worst_px)
        ++counts[DescribePositionInImage(r.pixel, result.features.image_size)];
    places.insert(std::max_element(counts.begin(), counts.end(),
                                   [](const auto& a, const auto& b) {
                                     return a.second < b.second;
                                   })
                      ->first);
  }
  metrics->unique_coverage_regions.assign(places.begin(), places.end());
}

void AddTriedAlternatives(const CalibrationResult& result,
                          CalibrationMetrics* metrics) {
  BudgetSummary& tried = metrics->tried;
  if (result.budget) tried = result.budget->facts;
  tried.model = result.camera.camera->Name();
  tried.mixed_cameras = result.mixed_cameras.has_value();
  constexpr double kMaxErrorRatio = 0.99;
  // All models are compared with rigid boards.
  const double current_error_px =
      result.camera.held_out ? result.camera.held_out->median_px : 0;
  double best_px = kMaxErrorRatio * current_error_px;
  for (const ModelMetrics& other : result.parametric_models) {
    tried.has_tried_noncentral_model |=
        other.model == models::kNonCentralGeneric;
    tried.has_tried_generic_model |= other.model == models::kCentralGeneric;
    if (!other.held_out || other.held_out->median_px >= best_px ||
        !HasLowerHeldOutError(other, result))
      continue;
    best_px = other.held_out->median_px;
    metrics->better_model = {other.model, best_px, current_error_px};
    tried.better_model = other.model;
  }
}

// Returns the ratio of the angular width of a pixel to its height at the centre
// of the calibrated area.
std::optional<double> PixelAspect(const CameraModel& camera) {
  const Eigen::Vector2d pixel = camera.area().center();
  const auto line = camera.Line(pixel);
  LinearizedProjection projection;
  if (!line ||
      !camera.Linearize(line->origin + line->direction, &pixel, 1, &projection))
    return std::nullopt;
  return projection.J_point.row(1).norm() / projection.J_point.row(0).norm();
}

Area GetFeatureArea(const Dataset& dataset) {
  Area area = {1e9, 1e9, -1e9, -1e9};
  for (const ImageFeatures& image : dataset.images)
    for (const Feature& feature : image.features) area.Extend(feature.pixel);
  return area;
}

void AddNearDuplicates(const CalibrationResult& result,
                       CalibrationMetrics* metrics) {
  std::set<std::string> views;
  for (const ImageFeatures& image : result.features.images)
    views.insert(image.image);
  for (const FeatureResidual& residual : result.held_out)
    views.insert(residual.image);
  metrics->held_out_duplicates = result.held_out_duplicates;
  const size_t num_copies = result.held_out_duplicates.size();
  metrics->images_kept = static_cast<int>(views.size() - num_copies);
  metrics->num_duplicate_images =
      static_cast<int>(CountDuplicates(result.near_duplicates) + num_copies);
}

CalibrationMetrics ComputeMetrics(const CalibrationResult& result,
                                  const std::set<std::string>& outlier_images) {
  CalibrationMetrics metrics;
  metrics.ambiguous_rotation_images = result.ambiguous_rotation_images;
  metrics.converged = result.converged;
  metrics.has_known_intrinsics = result.has_known_intrinsics;
  metrics.interrupted = result.checkpoint.has_value();
  metrics.image_size = result.camera.camera->image_size();
  metrics.features_area = GetFeatureArea(result.features);
  metrics.images_used = static_cast<int>(result.features.images.size());
  metrics.images_rejected = static_cast<int>(result.rejected_images.size());
  AddNearDuplicates(result, &metrics);
  metrics.images_with_too_few_features = static_cast<int>(std::count_if(
      result.rejected_images.begin(), result.rejected_images.end(),
      [](const auto& image) { return image.has_too_few_features; }));
  metrics.training = *result.camera.training;
  metrics.per_view_deformation = result.bends.has_value();
  metrics.held_out = metrics.per_view_deformation ? result.held_out_deformed
                                                  : result.camera.held_out;
  metrics.neighbor_correlation =
      ComputeSharedCorrelation(result, outlier_images);
  SeparateOutlierImages(result, outlier_images, &metrics);
  metrics.mixed_cameras = result.mixed_cameras;
  metrics.transformed_images = result.transformed_images;
  metrics.different_views = CountDistinctPoses(result);
  const std::vector<Eigen::Vector3d> normals = CollectBoardNormals(result);
  if (normals.size() == result.poses.size())
    metrics.tilt_rad = ComputeTilt(normals);
  AddSides(result, &metrics);
  metrics.fold_over = result.fold_over;
  metrics.flatness_error_m = result.flatness_error_m;
  metrics.fleet_distance = result.fleet_distance;
  if (result.line_delay && !result.line_delay->are_timestamps_consistent)
    metrics.timestamp_error = result.line_delay->unobservable_reason;
  metrics.pixel_aspect = PixelAspect(*result.camera.camera);
  if (const auto& uncertainty = result.camera.uncertainty) {
    const Area& area = result.camera.camera->area();
    const double median_px =
        uncertainty->lattice.MedianPx(area, metrics.features_area);
    if (std::isfinite(median_px)) metrics.median_stddev_px = median_px;
    metrics.valid_share =
        ComputeValidShare(*result.camera.camera, uncertainty->mask);
    metrics.valid_limit_px = uncertainty->max_stddev_px;
  }
  metrics.extrapolated = result.extrapolated;
  FindMisreadImages(result, &metrics);
  AddTriedAlternatives(result, &metrics);
  return metrics;
}

}  // namespace

std::vector<FeatureResidual> ComputeTrainingResiduals(
    const Pattern& pattern, const AdjustmentResult& adjusted, int camera,
    int num_threads) {
  const CalibrationProblem& problem = adjusted.problem;
  const std::vector<Residual> residuals =
      ComputeResiduals(adjusted.state, problem.views, num_threads);
  std::vector<FeatureResidual> result;
  size_t index = 0;
  for (size_t v = 0; v < problem.views.size(); ++v) {
    for (const Observation& observation : problem.views[v].observations) {
      const Residual& residual = residuals[index++];
      if (!residual.valid || problem.views[v].camera != camera) continue;
      const Feature feature =
          problem.GetFeature(pattern, static_cast<int>(v), observation);
      result.push_back({problem.images[v], feature.board, feature.column,
                        feature.row, observation.pixel, residual.error_px});
    }
  }
  return result;
}

void FillResult(const Pattern& pattern, const AdjustmentResult& adjusted,
                int camera, const std::optional<ImageCircle>& image_circle,
                int num_threads, CalibrationResult* result) {
  const CalibrationProblem& problem = adjusted.problem;
  std::unique_ptr<CameraModel> model = adjusted.state.cameras[camera]->Clone();
  model->SetImageCircle(image_circle);
  result->camera.camera = std::move(model);
  result->pattern = MakeEstimatedPattern(pattern, adjusted);
  result->features = UsedFeatures(pattern, problem, camera);
  for (size_t v = 0; v < problem.views.size(); ++v)
    if (problem.views[v].camera == camera)
      result->poses.push_back(
          {problem.images[v], pattern.boards[problem.boards[v]].id,
           adjusted.state.ComputeCameraFromPattern(problem.views[v])});
  result->training =
      ComputeTrainingResiduals(pattern, adjusted, camera, num_threads);
  result->camera.training = ComputeErrorMetrics(result->training);
  result->rejected_features = adjusted.rejected_features[camera];
  result->bends = GetDeformation(pattern, adjusted, camera);
  result->num_parameters = adjusted.state.cameras[camera]->NumParameters();
  result->converged = adjusted.summary.converged;
  result->bias_kl =
      ComputeBias(result->training, result->camera.camera->area());
  result->noise_bias_kl =
      ComputeNoiseBias(result->training, result->camera.camera->area());
  if (!result->camera.camera->IsCentral())
    result->noncentrality = ComputeNoncentrality(*result->camera.camera);
}

void KeepKnownCamera(const CameraFile& known, CalibrationResult* result) {
  CameraFile camera = known;
  camera.name = result->camera.name;
  camera.training = result->camera.training;
  camera.held_out.reset();
  result->camera = std::move(camera);
  result->has_known_intrinsics = true;
}

void FillUncertainty(const AdjustmentResult& adjusted, int camera,
                     const std::optional<ImageCircle>& image_circle,
                     const std::optional<double>& valid_limit_px,
                     int num_threads, CalibrationResult* result) {
  auto& uncertainty = result->camera.uncertainty;
  uncertainty.reset();
  result->extrapolated.reset();
  if (const auto estimate = EstimateUncertainty(adjusted, camera, image_circle,
                                                valid_limit_px, num_threads)) {
    uncertainty = estimate->uncertainty;
    result->extrapolated = estimate->extrapolated;
    result->jackknife_scale = uncertainty->jackknife_scale;
  }
  result->fold_over = MeasureFoldOver(
      *result->camera.camera, uncertainty ? &uncertainty->mask : nullptr);
}

void FillFleetDistance(const CameraModel& mean,
                       const PopulationCovariance& spread,
                       CalibrationResult* result) {
  constexpr size_t kMaxSamples = 2000;
  std::vector<Eigen::Vector2d> pixels;
  for (const ImageFeatures& image : result->features.images)
    for (const Feature& feature : image.features)
      pixels.push_back(feature.pixel);
  const CameraFile& camera = result->camera;
  result->fleet_distance = MeasureFleetDistance(
      mean, spread, *camera.camera,
      camera.uncertainty ? &camera.uncertainty->lattice : nullptr,
      SelectEvenly(pixels, kMaxSamples));
}

void FindUniqueCoverageImages(const AdjustmentResult& adjusted, int camera,
                              int num_threads, CalibrationResult* result) {
  // Three standard deviations, doubled because lenses are less smooth beyond
  // the features than the prior assumes.
  constexpr double kMinOutlierSigmas = 6;
  std::set<std::string> outlying = FindOutlierImages(result->held_out);
  for (const std::string& image : FindOutlierImages(result->training))
    outlying.erase(image);
  if (outlying.empty() || !result->cross_validated) return;
  const auto stddevs =
      PredictHeldOutStdDevs(adjusted, camera, outlying, num_threads);
  for (const auto& [image, stddev_px] : stddevs) {
    std::vector<double> norms;
    for (const FeatureResidual& r : result->held_out)
      if (r.image == image) norms.push_back(r.error_px.norm());
    if (Quantile(norms, 0.5) <= kMinOutlierSigmas * stddev_px)
      result->unique_coverage_images.push_back(image);
  }
}

void ListUnusedImages(const Dataset& measured,
                      const std::vector<RejectedImage>& skipped,
                      CalibrationResult* result) {
  std::vector<RejectedImage>& rejected = result->rejected_images;
  std::set<std::string> named;
  for (const ImageFeatures& image : result->features.images)
    if (!image.features.empty()) named.insert(image.image);
  for (const FeatureResidual& residual : result->held_out)
    named.insert(residual.image);
  for (const RejectedImage& image : rejected) named.insert(image.image);
  for (const ImageFeatures& image : measured.images) {
    if (!named.insert(image.image).second) continue;
    const bool has_few_features = image.features.size() < kMinViewFeatures;
    rejected.push_back({image.image,
                        has_few_features ? fmt::format("only {} features",
                                                       image.features.size())
                                         : "pose estimation failed",
                        has_few_features});
  }
  rejected.insert(rejected.end(), skipped.begin(), skipped.end());
}

void AssessResult(int num_threads, CalibrationResult* result) {
  if (!result->held_out.empty())
    result->camera.held_out = ComputeErrorMetrics(result->held_out);
  const std::vector<FeatureResidual>& residuals = GetAssessedResiduals(*result);
  const std::set<std::string> outlying = FindOutlierImages(residuals);
  result->residual_autocorrelation =
      ComputeNeighborCorrelation(FilterOutImages(residuals, outlying));
  if (result->camera.uncertainty && !result->held_out.empty() &&
      !result->has_known_intrinsics)
    result->camera.uncertainty->modes.excess_errors = EstimateExcessErrors(
        result->camera, FilterOutImages(result->held_out, outlying),
        result->cross_validated ? kTrainingFraction : 1, result->pattern,
        num_threads);
  CalibrationMetrics metrics = ComputeMetrics(*result, outlying);
  if (result->budget) {
    result->budget->facts = metrics.tried;
    metrics.limit = AssessBudget(*result->budget);
  }
  result->assessment = AssessCalibration(metrics);
}

bool HasSystematicErrors(const CalibrationResult& result) {
  const std::vector<FeatureResidual>& residuals = GetAssessedResiduals(result);
  if (residuals.empty()) return false;
  return HasCorrelatedErrors(
      ComputeSharedCorrelation(result, FindOutlierImages(residuals))
          .value_or(0),
      ComputeErrorMetrics(residuals));
}

bool IsSingleCamera(const CalibrationResult& result) {
  const auto has_correlated_errors =
      [](const std::vector<FeatureResidual>& residuals) {
        return HasCorrelatedErrors(
            ComputeNeighborCorrelation(residuals).value_or(0),
            ComputeErrorMetrics(residuals));
      };
  return !result.held_out.empty() && !result.training.empty() &&
         !has_correlated_errors(result.held_out) &&
         !has_correlated_errors(result.training);
}

}  // namespace raygrid
