#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>

#include "calibration/rig_calibration.h"
#include "dataset/error.h"
#include "dataset/parallel_for.h"
#include "evaluation/residual_statistics.h"
#include "experiments/experiment.h"
#include "experiments/picture_sheet.h"
#include "report/color_scale.h"
#include "simulation/random.h"
#include "simulation/simulated_lenses.h"
#include "simulation/simulated_rig.h"

namespace raygrid {
namespace {

constexpr double kBaselineM = 0.1, kDistanceM = 2, kSlope = 0.15;
constexpr double kFocalPx = 420;  // of the rectified images
constexpr int kFrames = 4;
constexpr int kStepPx = 5, kHalfWindowPx = 10;  // of matching
constexpr int kMinDisparity = 10, kMaxDisparity = 40;

// ---- Scene -----------------------------------------------------------------

// From 0 to 1, the same for the same place.
double Hash(int64_t x, int64_t y) {
  uint64_t h = static_cast<uint64_t>(x) * 0x9e3779b97f4a7c15u ^
               static_cast<uint64_t>(y) * 0xc2b2ae3d27d4eb4fu;
  h ^= h >> 29;
  h *= 0xbf58476d1ce4e5b9u;
  h ^= h >> 32;
  return static_cast<double>(h >> 11) * 0x1p-53;
}

double SmoothNoise(double x, double y) {
  const double x0 = std::floor(x), y0 = std::floor(y);
  const auto ease = [](double t) { return t * t * (3 - 2 * t); };
  const double u = ease(x - x0), v = ease(y - y0);
  const auto i = static_cast<int64_t>(x0), j = static_cast<int64_t>(y0);
  const double top = Hash(i, j) + u * (Hash(i + 1, j) - Hash(i, j));
  const double bottom =
      Hash(i, j + 1) + u * (Hash(i + 1, j + 1) - Hash(i, j + 1));
  return top + v * (bottom - top);
}

// Grey levels of a wall's paint, by metres.
double Paint(double x_m, double y_m) {
  double level = 0;
  for (const double wave_m : {0.018, 0.04, 0.1})
    level += SmoothNoise(x_m / wave_m + 1000 * wave_m, y_m / wave_m) / 3;
  return 30 + 200 * level;
}

// The wall z = kDistanceM + kSlope x in the left camera's frame.
Eigen::Vector3d OnWall(const ObservationLine& line) {
  const Eigen::Vector3d normal(-kSlope, 0, 1);
  const double depth =
      (kDistanceM - normal.dot(line.origin)) / normal.dot(line.direction);
  return line.origin + depth * line.direction;
}

// Without noise.
cv::Mat Photograph(const CameraModel& camera, const Pose& left_from_camera,
                   int num_threads) {
  const ImageSize& size = camera.image_size();
  cv::Mat levels(size.height, size.width, CV_32F, cv::Scalar(0));
  ParallelFor(size.height, num_threads, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      double sum = 0;
      int count = 0;
      for (int k = 0; k < 4; ++k) {
        const auto line =
            camera.Line({x - 0.25 + 0.5 * (k % 2), y - 0.25 + 0.5 * (k / 2)});
        if (!line) continue;
        const Eigen::Vector3d point =
            OnWall({left_from_camera * line->origin,
                    left_from_camera.rotation * line->direction});
        sum += Paint(point.x(), point.y());
        ++count;
      }
      levels.at<float>(y, x) = static_cast<float>(sum / std::max(1, count));
    }
  });
  return levels;
}

cv::Mat WithNoise(const cv::Mat& levels, double read_noise, uint64_t seed) {
  Random random(seed);
  cv::Mat noisy = levels.clone();
  for (int y = 0; y < noisy.rows; ++y)
    for (int x = 0; x < noisy.cols; ++x)
      noisy.at<float>(y, x) += static_cast<float>(read_noise * random.Normal());
  return noisy;
}

// ---- Rectification ---------------------------------------------------------

struct StereoCameras {
  std::string name;
  std::shared_ptr<const CameraModel> left, right;
  Pose right_from_left;

  Eigen::Vector3d RightCenter() const {
    return right_from_left.Inverse().translation;
  }
  /// The rectified frame: x towards the right camera, z about where the middle
  /// of the left image looks.
  Eigen::Matrix3d RectifiedFromLeft() const {
    const Eigen::Vector3d x = RightCenter().normalized();
    const Eigen::Vector3d middle = left->Unproject(left->area().center())
                                       .value_or(Eigen::Vector3d::UnitZ());
    const Eigen::Vector3d y = middle.cross(x).normalized();
    Eigen::Matrix3d rows;
    rows << x.transpose(), y.transpose(), x.cross(y).transpose();
    return rows;
  }
};

Eigen::Vector3d RectifiedRay(const ImageSize& size, double u, double v) {
  return {(u - (size.width - 1) / 2.0) / kFocalPx,
          (v - (size.height - 1) / 2.0) / kFocalPx, 1};
}

cv::Mat Rectified(const cv::Mat& image, const CameraModel& camera,
                  const Eigen::Matrix3d& camera_from_rectified,
                  int num_threads) {
  constexpr float kNowhere = -1e4f;
  cv::Mat x(image.size(), CV_32F), y(image.size(), CV_32F), rectified;
  ParallelFor(image.rows, num_threads, [&](int v) {
    for (int u = 0; u < image.cols; ++u) {
      const auto pixel = camera.Project(
          camera_from_rectified * RectifiedRay(camera.image_size(), u, v));
      x.at<float>(v, u) = pixel ? static_cast<float>(pixel->x()) : kNowhere;
      y.at<float>(v, u) = pixel ? static_cast<float>(pixel->y()) : kNowhere;
    }
  });
  cv::remap(image, rectified, x, y, cv::INTER_CUBIC, cv::BORDER_CONSTANT, -1);
  return rectified;
}

// ---- Matching --------------------------------------------------------------

// Zero-mean normalised cross-correlation of two windows in a row.
double Correlation(const cv::Mat& left, const cv::Mat& right, int u, int v,
                   int disparity) {
  double a = 0, b = 0, aa = 0, bb = 0, ab = 0;
  for (int j = -kHalfWindowPx; j <= kHalfWindowPx; ++j) {
    const float* l = left.ptr<float>(v + j) + u;
    const float* r = right.ptr<float>(v + j) + u - disparity;
    for (int i = -kHalfWindowPx; i <= kHalfWindowPx; ++i) {
      a += l[i];
      b += r[i];
      aa += l[i] * l[i];
      bb += r[i] * r[i];
      ab += l[i] * r[i];
    }
  }
  const double n = std::pow(2 * kHalfWindowPx + 1, 2);
  return (ab - a * b / n) /
         std::sqrt(std::max(1e-9, (aa - a * a / n) * (bb - b * b / n)));
}

bool IsWhole(const cv::Mat& image, int u, int v) {
  for (int j = -kHalfWindowPx; j <= kHalfWindowPx; ++j)
    for (int i = -kHalfWindowPx; i <= kHalfWindowPx; ++i)
      if (image.at<float>(v + j, u + i) < 0) return false;
  return true;
}

// The best disparity of all, with a parabola through its neighbours.
std::optional<double> Match(const cv::Mat& left, const cv::Mat& right, int u,
                            int v) {
  constexpr double kMinCorrelation = 0.8;
  if (u - kMaxDisparity - 1 < kHalfWindowPx || !IsWhole(left, u, v))
    return std::nullopt;
  std::vector<double> scores;
  for (int d = kMinDisparity; d <= kMaxDisparity; ++d)
    scores.push_back(Correlation(left, right, u, v, d));
  const auto best = std::max_element(scores.begin(), scores.end());
  const auto k = best - scores.begin();
  if (*best < kMinCorrelation || k == 0 ||
      k + 1 == static_cast<std::ptrdiff_t>(scores.size()) ||
      !IsWhole(right, u - kMinDisparity - static_cast<int>(k), v))
    return std::nullopt;
  const double below = best[-1], above = best[1];
  return kMinDisparity + static_cast<double>(k) +
         (below - above) / (2 * (below - 2 * *best + above));
}

// ---- Depth -----------------------------------------------------------------

// Over a lattice of rectified pixels: how far the cloud is beyond the wall once
// both are brought together by a similarity (Umeyama, 1991); not a number where
// nothing matched.
struct DepthMap {
  int columns = 0;
  std::vector<double> error_mm;
  double similarity_scale = 1;
};

DepthMap MeasureDepth(const StereoCameras& cameras, const CameraModel& truth,
                      const cv::Mat& left, const cv::Mat& right,
                      int num_threads) {
  const ImageSize& size = truth.image_size();
  const Eigen::Matrix3d left_from_rectified =
      cameras.RectifiedFromLeft().transpose();
  const cv::Mat a =
      Rectified(left, *cameras.left, left_from_rectified, num_threads);
  const cv::Mat b = Rectified(
      right, *cameras.right,
      cameras.right_from_left.rotation.toRotationMatrix() * left_from_rectified,
      num_threads);
  const double baseline_m = cameras.RightCenter().norm();
  DepthMap map;
  map.columns = (size.width - 2 * kHalfWindowPx - 1) / kStepPx + 1;
  const int rows = (size.height - 2 * kHalfWindowPx - 1) / kStepPx + 1;
  std::vector<std::optional<Eigen::Vector3d>> cloud(map.columns * rows),
      wall(map.columns * rows);
  ParallelFor(rows, num_threads, [&](int j) {
    for (int i = 0; i < map.columns; ++i) {
      const int u = kHalfWindowPx + i * kStepPx,
                v = kHalfWindowPx + j * kStepPx;
      const Eigen::Vector3d ray =
          left_from_rectified * RectifiedRay(size, u, v);
      const auto pixel = cameras.left->Project(ray);
      const auto line = pixel ? truth.Line(*pixel) : std::nullopt;
      const auto disparity = line ? Match(a, b, u, v) : std::nullopt;
      if (!disparity) continue;
      cloud[j * map.columns + i] = ray * (baseline_m * kFocalPx / *disparity);
      wall[j * map.columns + i] = OnWall(*line);
    }
  });
  std::vector<size_t> matched;
  for (size_t k = 0; k < cloud.size(); ++k)
    if (cloud[k]) matched.push_back(k);
  if (matched.size() < 100)
    throw Error(ExitCode::kTooFew, "stereo-depth: hardly anything matched");
  Eigen::Matrix3Xd from(3, matched.size()), to(3, matched.size());
  for (size_t k = 0; k < matched.size(); ++k) {
    from.col(static_cast<Eigen::Index>(k)) = *cloud[matched[k]];
    to.col(static_cast<Eigen::Index>(k)) = *wall[matched[k]];
  }
  const Eigen::Matrix4d similarity = Eigen::umeyama(from, to, true);
  map.similarity_scale =
      std::cbrt(similarity.topLeftCorner<3, 3>().determinant());
  map.error_mm.assign(cloud.size(), NAN);
  for (size_t k = 0; k < matched.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    map.error_mm[matched[k]] =
        1000 *
        ((similarity * from.col(column).homogeneous()).z() - to(2, column));
  }
  return map;
}

// Of one image's map and of the mean of several, whose matching errors are
// still those of single windows; and of medians over blocks of it.
struct DepthErrors {
  double one_median_mm = 0, mean_median_mm = 0, blocks_rms_mm = 0, scale = 1;
  int columns = 0;
  std::vector<double> mean_mm;
};

double MedianSize(const std::vector<double>& values) {
  std::vector<double> sizes;
  for (const double value : values)
    if (std::isfinite(value)) sizes.push_back(std::abs(value));
  return Quantile(sizes, 0.5);
}

double BlocksRms(const std::vector<double>& values, int columns) {
  constexpr int kBlock = 8, kMinValues = kBlock * kBlock / 2;
  std::map<int, std::vector<double>> blocks;
  for (int k = 0; k < static_cast<int>(values.size()); ++k)
    if (std::isfinite(values[k]))
      blocks[k / columns / kBlock * columns + k % columns / kBlock].push_back(
          values[k]);
  double sum = 0;
  int count = 0;
  for (const auto& [block, errors] : blocks) {
    if (static_cast<int>(errors.size()) < kMinValues) continue;
    sum += std::pow(Quantile(errors, 0.5), 2);
    ++count;
  }
  return std::sqrt(sum / std::max(1, count));
}

DepthErrors MeasureFrames(const StereoCameras& cameras,
                          const CameraModel& truth, const cv::Mat& left,
                          const cv::Mat& right,
                          const ExperimentOptions& options) {
  DepthErrors errors;
  for (int frame = 0; frame < kFrames; ++frame) {
    const uint64_t seed = options.seed * 1009 + 2 * frame;
    const DepthMap map =
        MeasureDepth(cameras, truth, WithNoise(left, options.read_noise, seed),
                     WithNoise(right, options.read_noise, seed + 1),
                     NumThreads(options.num_threads));
    errors.columns = map.columns;
    errors.scale = map.similarity_scale;
    if (frame == 0) {
      errors.one_median_mm = MedianSize(map.error_mm);
      errors.mean_mm.assign(map.error_mm.size(), 0);
    }
    for (size_t k = 0; k < map.error_mm.size(); ++k)
      errors.mean_mm[k] += map.error_mm[k] / kFrames;
  }
  errors.mean_median_mm = MedianSize(errors.mean_mm);
  errors.blocks_rms_mm = BlocksRms(errors.mean_mm, errors.columns);
  return errors;
}

// ---- Calibration -----------------------------------------------------------

std::vector<StereoCameras> CalibratePairs(const SimulatedRig& rig,
                                          const ExperimentOptions& options) {
  const Pattern pattern = ChessboardPattern(30, 24, 0.02);
  SimulationOptions simulation;
  simulation.num_images = options.num_images;
  simulation.seed = options.seed + 1;
  const SimulatedRigObservations seen = SimulateRig(rig, pattern, simulation);
  CalibrationOptions calibration;
  calibration.flat_board = true;
  calibration.hold_out = {seen.datasets[0].images.back().image};
  calibration.num_threads = options.num_threads;
  calibration.cell_px =
      std::max(options.size.width, options.size.height) / 16.0;
  std::vector<StereoCameras> pairs;
  for (const char* model :
       {"opencv", "thin-prism-fisheye", "central-generic"}) {
    calibration.model = model;
    const RigResult result = CalibrateRig({{"left", seen.datasets[0], {}, {}},
                                           {"right", seen.datasets[1], {}, {}}},
                                          pattern, calibration);
    pairs.push_back(
        {model, result.cameras[0].camera.camera,
         result.cameras[1].camera.camera,
         result.camera_from_rig[1] * result.camera_from_rig[0].Inverse()});
    if (options.progress) options.progress(0.2 * double(pairs.size()));
  }
  pairs.push_back({"truth", rig.cameras[0], rig.cameras[1],
                   rig.camera_from_rig[1] * rig.camera_from_rig[0].Inverse()});
  return pairs;
}

}  // namespace

ExperimentResult MeasureStereoDepth(const ExperimentOptions& options) {
  const std::shared_ptr<const CameraModel> lens =
      SimulatedLens("example", options.size);
  const SimulatedRig rig = CamerasInARow(lens, 2, kBaselineM);
  const std::vector<StereoCameras> pairs = CalibratePairs(rig, options);
  const int num_threads = NumThreads(options.num_threads);
  const cv::Mat left = Photograph(*lens, {}, num_threads);
  const cv::Mat right =
      Photograph(*lens, rig.camera_from_rig[1].Inverse(), num_threads);

  ExperimentResult table;
  const double mm_per_px =
      1000 * kDistanceM * kDistanceM / (kBaselineM * kFocalPx);
  table.conditions = {
      {"scene", fmt::format("a painted wall, {:g} m away, inclined by {:g}",
                            kDistanceM, kSlope)},
      {"cameras", fmt::format("two alike, lens example, {:g} m apart, "
                              "calibrated together from {} instants",
                              kBaselineM, options.num_images)},
      {"matching",
       fmt::format("rectified, f = {:g} px; exhaustive along rows by zero-mean "
                   "normalised cross-correlation, {} px windows, parabola",
                   kFocalPx, 2 * kHalfWindowPx + 1)},
      {"d = b f / x",
       fmt::format("1 px of disparity is {:.1f} mm of depth", mm_per_px)},
      {"aligned", "clouds to the wall by a similarity (Umeyama)"},
      {"blocks", "of 8 x 8 matches, in the mean of the images"},
      {"noise", fmt::format("{:g} grey levels", options.read_noise)},
      {"seed", std::to_string(options.seed)}};
  table.columns = {"cameras",
                   "one_image_median_mm",
                   fmt::format("mean_of_{}_median_mm", kFrames),
                   "blocks_rms_mm",
                   "blocks_rms_disparity_px",
                   "similarity_scale"};
  table.chart.title = "Error of depth by stereo";
  table.chart.note =
      "noise and errors of single windows average out, a bias does not";
  table.chart.x_label = "calibration";
  table.chart.y_label = "error of depth, mm";
  table.chart.is_logarithmic = true;
  ChartSeries one = {"median, one image", {}, false},
              mean = {fmt::format("median, mean of {}", kFrames), {}, false},
              blocks = {"RMS of medians over blocks", {}, false};
  std::vector<SheetPicture> maps;
  double limit_mm = 0;
  for (const StereoCameras& pair : pairs) {
    const DepthErrors errors = MeasureFrames(pair, *lens, left, right, options);
    const double place = static_cast<double>(table.chart.ticks.size());
    table.rows.push_back({pair.name, errors.one_median_mm,
                          errors.mean_median_mm, errors.blocks_rms_mm,
                          errors.blocks_rms_mm / mm_per_px, errors.scale});
    table.chart.ticks.push_back({place, pair.name});
    one.points.push_back({place, errors.one_median_mm});
    mean.points.push_back({place, errors.mean_median_mm});
    blocks.points.push_back({place, errors.blocks_rms_mm});
    if (limit_mm == 0) limit_mm = 2.5 * errors.blocks_rms_mm;
    maps.push_back(
        {fmt::format("{}: blocks {:.1f} mm RMS", pair.name,
                     errors.blocks_rms_mm),
         HeatMap(errors.mean_mm, errors.columns, -limit_mm, limit_mm, 3)});
    if (options.progress) options.progress(0.6 + 0.1 * (place + 1));
  }
  table.chart.series = {one, mean, blocks};
  table.pictures.push_back(
      {"bias",
       PictureSheet(maps,
                    {fmt::format("Depth less true depth, mean of {} image "
                                 "pairs, over the left rectified image:",
                                 kFrames),
                     fmt::format("dark blue {:.0f} mm (too near), grey 0, "
                                 "yellow {:.0f} mm (too far), white no match",
                                 -limit_mm, limit_mm)},
                    nullptr)});
  return table;
}

}  // namespace raygrid
