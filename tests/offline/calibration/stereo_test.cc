// The rows of rectified pairs, against the truth that rigs were simulated with,
// and on photographs against OpenCV.

#include <cstdio>
#include <filesystem>
#include <opencv2/calib3d.hpp>

#include "calibration/calibration.h"
#include "camera/equivalent_central_camera.h"
#include "features/pattern_detector.h"
#include "packing/blob_camera.h"
#include "packing/pack.h"
#include "packing/rectification.h"
#include "simulation/simulated_rig.h"
#include "support.h"
#include "test_boards.h"

namespace raygrid {
namespace {

// ---- Figures of rows -------------------------------------------------------

struct RowErrors {
  std::vector<double> errors_px;

  double RmsPx() const {
    double sum = 0;
    for (const double error : errors_px) sum += error * error;
    return std::sqrt(sum / static_cast<double>(errors_px.size()));
  }
  double WorstPx() const {
    double worst = 0;
    for (const double error : errors_px)
      worst = std::max(worst, std::abs(error));
    return worst;
  }
  void Print(const char* what) const {
    std::printf("%s: row disparity RMS %.4f px, worst %.3f, %zu points\n", what,
                RmsPx(), WorstPx(), errors_px.size());
  }
};

StereoCamera Calibrated(const RigResult& result, int c) {
  const CalibrationResult& camera = result.cameras[c];
  return {camera.camera.name, *camera.camera.camera, result.camera_from_rig[c]};
}

BlobCamera BlobOfPair(const RigResult& result, const Rectification& rectified,
                      int c) {
  PackOptions options;
  options.remaps = {rectified.views[c]};
  BlobCamera blob("packed", PackCamera(result.cameras[c].camera, options).blob);
  return blob;
}

// The place in the view, by the runtime, of what a pixel shows.
std::optional<Eigen::Vector2d> PointInView(const BlobCamera& blob,
                                           const Eigen::Vector2d& pixel) {
  const rg_pixel source = {
      static_cast<int32_t>(std::lround(pixel.x() * 65536)),
      static_cast<int32_t>(std::lround(pixel.y() * 65536))};
  rg_pixel shown;
  rg_camera camera = blob.camera();
  if (rg_select_remap(&camera, 0) != RG_OK ||
      rg_undistort_point(&camera, source, &shown) != RG_OK)
    return std::nullopt;
  return Eigen::Vector2d(shown.x_q16, shown.y_q16) / 65536;
}

// ---- Simulated rigs --------------------------------------------------------

SimulatedRig RigOf(const std::string& lens, const ImageSize& size) {
  const std::shared_ptr<const CameraModel> camera =
      MakeSimulatedCamera(lens, size);
  return {{camera, camera},
          {{}, {RotationFromVector({0.02, -0.05, 0.03}), {-0.1, 0.004, 0.01}}}};
}

RigResult CalibratedRig(const SimulatedRig& rig, const std::string& model) {
  SimulationOptions options;
  options.num_images = 36;
  const SimulatedRigObservations seen =
      SimulateRig(rig, FineTestBoard(), options);
  CalibrationOptions calibration;
  calibration.model = model;
  calibration.knot_spacing_px = 60;
  calibration.hold_out = {seen.datasets[0].images.back().image};
  return Calibrate({{"left", seen.datasets[0]}, {"right", seen.datasets[1]}},
                   FineTestBoard(), calibration);
}

// Random points at distances that far(&random) chooses, seen by the true
// cameras where the calibrated ones are trusted, at the places shown(camera,
// pixel).
template <typename Far, typename Shown>
RowErrors RowsOfPoints(const SimulatedRig& rig, const RigResult& result,
                       int count, const Far& far, const Shown& shown) {
  TestRandom random(4);
  RowErrors rows;
  for (int k = 0; k < count; ++k) {
    const auto line =
        rig.cameras[0]->Line(random.PixelIn(rig.cameras[0]->area()));
    const Eigen::Vector3d point = PointAlong(*line, far(&random));
    std::optional<Eigen::Vector2d> places[2];
    for (const int c : {0, 1}) {
      const auto pixel =
          rig.cameras[c]->Project(rig.camera_from_rig[c] * point);
      if (!pixel ||
          !WholeImage(rig.cameras[c]->image_size()).Contains(*pixel) ||
          !result.cameras[c].camera.uncertainty->mask.IsValidAt(*pixel))
        break;
      places[c] = shown(c, *pixel);
    }
    if (places[0] && places[1])
      rows.errors_px.push_back(places[0]->y() - places[1]->y());
  }
  return rows;
}

// Random points before the pair, inside both views.
RowErrors RowsAgainstTruth(const SimulatedRig& rig, const RigResult& result) {
  const Rectification rectified =
      Rectify(Calibrated(result, 0), Calibrated(result, 1), {});
  const BlobCamera blobs[] = {BlobOfPair(result, rectified, 0),
                              BlobOfPair(result, rectified, 1)};
  return RowsOfPoints(
      rig, result, 20000,
      [](TestRandom* random) {
        return std::exp(random->Uniform(std::log(0.3), 4));
      },
      [&](int c, const Eigen::Vector2d& pixel) {
        auto place = PointInView(blobs[c], pixel);
        if (place && !WholeImage(rectified.views[c].size).Contains(*place))
          place.reset();
        return place;
      });
}

void ExpectRowsOf(const std::string& lens) {
  const SimulatedRig rig = RigOf(lens, {640, 480});
  const RowErrors rows =
      RowsAgainstTruth(rig, CalibratedRig(rig, "central-generic"));
  rows.Print((lens + " rig").c_str());
  EXPECT_GT(rows.errors_px.size(), 3000u);
  EXPECT_LE(rows.RmsPx(), 0.03);
  EXPECT_LE(rows.WorstPx(), 0.1);
}

// Points at about the distance, by the views' exact sources.
RowErrors RowsOfLines(const SimulatedRig& rig, const RigResult& result,
                      double distance_m) {
  const EquivalentCentralCamera cameras[] = {
      {*result.cameras[0].camera.camera, distance_m},
      {*result.cameras[1].camera.camera, distance_m}};
  const Rectification rectified =
      Rectify({"left", cameras[0], result.camera_from_rig[0]},
              {"right", cameras[1], result.camera_from_rig[1]}, {});
  return RowsOfPoints(
      rig, result, 5000,
      [distance_m](TestRandom* random) {
        return distance_m * random->Uniform(0.95, 1.05);
      },
      [&](int c, const Eigen::Vector2d& pixel) {
        const auto ray = cameras[c].Unproject(pixel);
        return ray ? rectified.views[c].Pixel(*ray) : std::nullopt;
      });
}

TEST(Stereo, RigsOfLinesKeepRowsAtTheirDistance) {
  const SimulatedRig rig = RigOf("glass", {320, 240});
  const RigResult result = CalibratedRig(rig, "noncentral-generic");
  const RowErrors rows = RowsOfLines(rig, result, 0.6);
  rows.Print("glass rig at 0.6 m");
  EXPECT_GT(rows.errors_px.size(), 1000u);
  EXPECT_LE(rows.RmsPx(), 0.03);
  EXPECT_LE(rows.WorstPx(), 0.1);
}

TEST(Stereo, WideRigsKeepRows) { ExpectRowsOf("wide"); }
TEST(Stereo, FisheyeRigsKeepRows) { ExpectRowsOf("fisheye"); }

// ---- Photographs -----------------------------------------------------------

constexpr int kNumHeldOut = 3;

// Corners of the pairs that show the board in both images, by instants.
struct Corners {
  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> pixels[2];
};

struct PhotographedPairs {
  Pattern pattern = ChessboardPattern(9, 6, 0.025);
  Dataset datasets[2];
  std::vector<std::string> held_out;
  Corners training, test;
};

// The corners of the left photographs and the right ones are given one name.
Dataset DetectIn(const std::string& folder, const Pattern& pattern) {
  Dataset dataset =
      DetectFeatures(FindImages({folder}).paths, pattern, 0, [](double) {});
  for (ImageFeatures& image : dataset.images)
    image.image = image.image.substr(image.image.find_first_of("0123456789"));
  return dataset;
}

void AddPair(const ImageFeatures& left, const ImageFeatures& right,
             const Pattern& pattern, Corners* corners) {
  corners->points.emplace_back();
  for (auto& pixels : corners->pixels) pixels.emplace_back();
  const double square_m = pattern.boards[0].square_m;
  for (const Feature& a : left.features)
    for (const Feature& b : right.features) {
      if (a.column != b.column || a.row != b.row) continue;
      corners->points.back().emplace_back(a.column * square_m, a.row * square_m,
                                          0);
      corners->pixels[0].back().emplace_back(a.pixel.x(), a.pixel.y());
      corners->pixels[1].back().emplace_back(b.pixel.x(), b.pixel.y());
    }
}

PhotographedPairs ReadPairs() {
  PhotographedPairs pairs;
  const char* sides[] = {"/left", "/right"};
  for (const int c : {0, 1})
    pairs.datasets[c] =
        DetectIn(RAYGRID_PHOTOGRAPHS + std::string(sides[c]), pairs.pattern);
  int count = 0;
  for (const ImageFeatures& left : pairs.datasets[0].images)
    for (const ImageFeatures& right : pairs.datasets[1].images) {
      if (left.image != right.image || left.features.empty() ||
          right.features.empty())
        continue;
      const bool is_test =
          ++count % 4 == 0 &&
          static_cast<int>(pairs.held_out.size()) < kNumHeldOut;
      if (is_test) pairs.held_out.push_back(left.image);
      AddPair(left, right, pairs.pattern,
              is_test ? &pairs.test : &pairs.training);
    }
  return pairs;
}

// OpenCV's pair, with one of its numbers of coefficients.
struct OpenCvPair {
  cv::Matx33d k[2], r[2];
  cv::Mat d[2];
};

OpenCvPair CalibratePairByOpenCv(const Corners& corners, int flags) {
  OpenCvPair pair;
  const cv::Size size(640, 480);
  std::vector<cv::Mat> rotations, translations;
  for (const int c : {0, 1})
    cv::calibrateCamera(corners.points, corners.pixels[c], size, pair.k[c],
                        pair.d[c], rotations, translations, flags);
  cv::Mat r, t, e, f, p1, p2, q;
  cv::stereoCalibrate(
      corners.points, corners.pixels[0], corners.pixels[1], pair.k[0],
      pair.d[0], pair.k[1], pair.d[1], size, r, t, e, f,
      cv::CALIB_USE_INTRINSIC_GUESS | flags,
      cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 100,
                       1e-9));
  cv::stereoRectify(pair.k[0], pair.d[0], pair.k[1], pair.d[1], size, r, t,
                    pair.r[0], pair.r[1], p1, p2, q);
  return pair;
}

// Rows in pixels of the other's views.
RowErrors RowsOfOpenCv(const OpenCvPair& pair, const Corners& corners,
                       const VirtualView& view) {
  const cv::Matx33d k(view.focal_px.x(), 0, view.center_px.x(), 0,
                      view.focal_px.y(), view.center_px.y(), 0, 0, 1);
  RowErrors rows;
  for (size_t i = 0; i < corners.points.size(); ++i) {
    std::vector<cv::Point2f> shown[2];
    for (const int c : {0, 1})
      cv::undistortPoints(corners.pixels[c][i], shown[c], pair.k[c], pair.d[c],
                          pair.r[c], k);
    for (size_t j = 0; j < shown[0].size(); ++j)
      rows.errors_px.push_back(shown[0][j].y - shown[1][j].y);
  }
  return rows;
}

// Those that both blobs show.
Corners ShownBy(const BlobCamera& left, const BlobCamera& right,
                const Corners& corners, RowErrors* rows) {
  Corners shown = corners;
  for (size_t i = 0; i < corners.points.size(); ++i) {
    for (auto& pixels : shown.pixels) pixels[i].clear();
    for (size_t j = 0; j < corners.points[i].size(); ++j) {
      const cv::Point2f &a = corners.pixels[0][i][j],
                        &b = corners.pixels[1][i][j];
      const auto in_left = PointInView(left, {a.x, a.y});
      const auto in_right = PointInView(right, {b.x, b.y});
      if (!in_left || !in_right) continue;
      shown.pixels[0][i].push_back(a);
      shown.pixels[1][i].push_back(b);
      rows->errors_px.push_back(in_left->y() - in_right->y());
    }
  }
  return shown;
}

TEST(Stereo, HeldOutRowsOfPhotographsAreNoWorseThanOpenCvs) {
  if (!std::filesystem::exists(RAYGRID_PHOTOGRAPHS "/left"))
    GTEST_SKIP() << "no photographs; tools/fetch_photographs fetches them";
  const PhotographedPairs pairs = ReadPairs();
  ASSERT_EQ(pairs.test.points.size(), static_cast<size_t>(kNumHeldOut));
  CalibrationOptions options;
  options.hold_out = pairs.held_out;
  const RigResult result =
      Calibrate({{"left", pairs.datasets[0]}, {"right", pairs.datasets[1]}},
                pairs.pattern, options);
  RectificationRequest as_sharp_as_the_images;
  as_sharp_as_the_images.hfov_deg = 61.6;
  const Rectification rectified = Rectify(
      Calibrated(result, 0), Calibrated(result, 1), as_sharp_as_the_images);
  RowErrors own;
  const Corners test =
      ShownBy(BlobOfPair(result, rectified, 0),
              BlobOfPair(result, rectified, 1), pairs.test, &own);
  own.Print("held out, central-generic");
  EXPECT_GE(own.errors_px.size(), 0.99 * 54 * kNumHeldOut);
  const VirtualView& view = rectified.views[0];
  for (const int flags : {0, static_cast<int>(cv::CALIB_RATIONAL_MODEL)}) {
    const RowErrors theirs =
        RowsOfOpenCv(CalibratePairByOpenCv(pairs.training, flags), test, view);
    theirs.Print(flags == 0 ? "held out, cv::stereoCalibrate"
                            : "held out, cv::stereoCalibrate, rational");
    EXPECT_EQ(theirs.errors_px.size(), own.errors_px.size());
    EXPECT_LE(own.RmsPx(), theirs.RmsPx());
  }
}

}  // namespace
}  // namespace raygrid
