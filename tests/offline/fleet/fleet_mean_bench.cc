// The use of a fleet's middle camera for units with few images, by the
// truth. Run by hand; --help tells the options:
//   fleet_mean_bench [--family NAME] [--fleet N]

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>

#include "calibration/calibration.h"
#include "dataset/files.h"
#include "dataset/parallel_for.h"
#include "decentred_family.h"
#include "evaluation/model_difference.h"
#include "evaluation/residual_statistics.h"
#include "fleet/fleet_mean.h"
#include "fleet/population_estimation.h"
#include "lens_family.h"
#include "simulation/simulated_observations.h"

namespace raygrid {
namespace {

constexpr ImageSize kSize = {640, 480};
constexpr int kFleetImages = 40, kFeatures = 120;
constexpr double kStepPx = 8;

constexpr Area kArea = {-1, -1, 640, 480};

// Strangers differ so many times as much in all of it.
FamilyScatter ScatterOf(const std::string& name, double times) {
  FamilyScatter scatter;
  scatter.focal *= times;
  scatter.k1 *= times;
  if (name == "simple") return scatter;
  scatter.centre_px = times * 3;
  scatter.k2 = times * 0.0006;
  scatter.p = times * 0.0003;
  scatter.bumps_px = times * (name == "bumpy" ? 0.1 : 0.02);
  return scatter;
}

DecentredFamilyLens::Scatter DecentredScatter(double times) {
  DecentredFamilyLens::Scatter scatter;
  for (double* deviation : {&scatter.focal, &scatter.centre, &scatter.radial3,
                            &scatter.radial5, &scatter.tilt, &scatter.bumps})
    *deviation *= times;
  return scatter;
}

// A camera that others lie around, and how they differ from it, if known.
struct Around {
  std::shared_ptr<const CameraModel> camera = nullptr;
  std::shared_ptr<const PopulationCovariance> spread = nullptr;
};

Around AroundOf(const CameraFile& file) {
  Around around = {file.camera};
  if (file.spread)
    around.spread = std::make_shared<PopulationCovariance>(*file.spread);
  return around;
}

// Images and the part of their width and height that features are in.
struct Sight {
  int num_images = 10;
  double part = 1;
};

void KeepMiddle(double part, Dataset* dataset) {
  const Eigen::Vector2d middle = kArea.center(),
                        half = Eigen::Vector2d(kSize.width, kSize.height) / 2;
  for (ImageFeatures& image : dataset->images) {
    std::vector<Feature> kept;
    for (const Feature& feature : image.features)
      if (((feature.pixel - middle).array().abs() <= part * half.array()).all())
        kept.push_back(feature);
    image.features = kept;
  }
}

CalibrationResult CalibrateLens(const CameraModel& lens, const Sight& sight,
                                uint64_t seed, const Around& around) {
  const Pattern pattern = ChessboardPattern(30, 24, 0.02);
  SimulationOptions simulation;
  simulation.num_images = sight.num_images;
  simulation.features_per_image =
      static_cast<int>(kFeatures / (sight.part * sight.part));
  simulation.seed = seed;
  CalibrationOptions options;
  options.num_threads = 1;
  options.like = around.camera;
  options.prior_population = around.spread;
  // One image held out and cells of 1/16 of the width save the time of
  // cross-validation.
  ++simulation.num_images;
  Dataset dataset = SimulateObservations(lens, pattern, simulation).dataset;
  KeepMiddle(sight.part, &dataset);
  options.hold_out = {dataset.images.back().image};
  options.knot_spacing_px = kSize.width / 16.0;
  return Calibrate(dataset, pattern, options);
}

struct UnitErrors {
  double median_px = 0, rms_px = 0, p99_px = 0, ratio = 0;
  std::optional<FleetDistance> distance = {};
};

// ratio: of the error in an axis by the stated deviation.
UnitErrors ErrorsOf(const CameraModel& lens, const CameraFile& camera) {
  const ModelDifference difference =
      CompareModels(lens, *camera.camera, kStepPx);
  UnitErrors errors = {difference.median_px, difference.rms_px,
                       difference.p99_px};
  double sum = 0, count = 0;
  for (size_t i = 0; i < difference.pixels.size(); ++i) {
    const double stated_px = camera.uncertainty->lattice.At(
        camera.camera->area(), difference.pixels[i]);
    if (!std::isfinite(stated_px)) continue;
    sum += difference.error_px[i].squaredNorm() / 2 / (stated_px * stated_px);
    ++count;
  }
  errors.ratio = std::sqrt(sum / count);
  return errors;
}

double MedianOf(const std::vector<UnitErrors>& units,
                double UnitErrors::*metric) {
  std::vector<double> values;
  for (const UnitErrors& unit : units) values.push_back(unit.*metric);
  return Quantile(values, 0.5);
}

// Whether units are told to be strangers, by how far they lie from the middle.
void PrintDistances(const std::vector<UnitErrors>& units) {
  std::vector<double> times;
  int num_reported = 0;
  for (const UnitErrors& unit : units) {
    if (!unit.distance) return;
    times.push_back(unit.distance->rms_px / unit.distance->units_px);
    num_reported += unit.distance->IsOutlier();
  }
  std::printf(
      "     from the middle %.2f to %.2f times as far as units, median %.2f; "
      "%d of %zu told\n",
      Quantile(times, 0), Quantile(times, 1), Quantile(times, 0.5),
      num_reported, units.size());
}

void Measure(const std::string& name,
             const std::vector<std::unique_ptr<CameraModel>>& lenses,
             const Sight& sight, const Around& around) {
  std::vector<UnitErrors> errors(lenses.size());
  ParallelFor(static_cast<int>(lenses.size()), NumThreads(0), [&](int u) {
    const CalibrationResult result =
        CalibrateLens(*lenses[u], sight, 5000 + u, around);
    errors[u] = ErrorsOf(*lenses[u], result.camera);
    errors[u].distance = result.fleet_distance;
  });
  double most = 0;
  for (const UnitErrors& unit : errors) most = std::max(most, unit.p99_px);
  std::printf(
      "%4d images of %3.0f %%, %-28s median %.4f  RMS %.4f  p99 %.4f (most "
      "%.3f) px, "
      "error/stated %.2f\n",
      sight.num_images, 100 * sight.part, name.c_str(),
      MedianOf(errors, &UnitErrors::median_px),
      MedianOf(errors, &UnitErrors::rms_px),
      MedianOf(errors, &UnitErrors::p99_px), most,
      MedianOf(errors, &UnitErrors::ratio));
  PrintDistances(errors);
  std::fflush(stdout);
}

// Lenses of a family, one after the other, and its middle.
struct CameraModels {
  std::function<std::unique_ptr<CameraModel>()> draw;
  std::shared_ptr<const CameraModel> middle;
};

CameraModels LensesOf(const std::string& family, uint64_t seed,
                      double times = 1) {
  if (family == "decentred") {
    const auto random = std::make_shared<Random>(seed);
    return {[random, times] {
              return DecentredFamilyLens(kSize, kArea, DecentredScatter(times),
                                         random.get())
                  .Clone();
            },
            std::make_shared<DecentredFamilyLens>(kSize, kArea)};
  }
  const auto lenses =
      std::make_shared<LensFamily>(ScatterOf(family, times), seed);
  return {[lenses] { return lenses->Draw().Clone(); },
          std::make_shared<SimulatedCamera>(LensFamily::Mean())};
}

// Errors of the fleet's units, and what of them all share: no middle camera can
// average it away.
void MeasureFleet(const std::vector<std::unique_ptr<CameraModel>>& lenses,
                  const std::vector<CameraFile>& files) {
  if (files.empty()) return;
  std::map<std::pair<double, double>, Eigen::Vector2d> sums;
  std::vector<double> rms, p99, shared;
  for (size_t u = 0; u < files.size(); ++u) {
    const ModelDifference difference =
        CompareModels(*lenses[u], *files[u].camera, kStepPx);
    rms.push_back(difference.rms_px);
    p99.push_back(difference.p99_px);
    for (size_t i = 0; i < difference.pixels.size(); ++i) {
      const Eigen::Vector2d& pixel = difference.pixels[i];
      sums.try_emplace({pixel.x(), pixel.y()}, Eigen::Vector2d::Zero())
          .first->second += difference.error_px[i] / files.size();
    }
  }
  double squares = 0;
  for (const auto& [pixel, mean] : sums) {
    squares += mean.squaredNorm() / sums.size();
    shared.push_back(mean.norm());
  }
  std::printf(
      "%zu units of %d images: RMS %.4f, p99 %.4f px (medians); their mean "
      "error: median %.4f, RMS %.4f, p99 %.4f px\n",
      files.size(), kFleetImages, Quantile(rms, 0.5), Quantile(p99, 0.5),
      Quantile(shared, 0.5), std::sqrt(squares), Quantile(shared, 0.99));
}

std::vector<CameraFile> CalibrateFleet(
    const std::vector<std::unique_ptr<CameraModel>>& lenses,
    const std::string& prefix, const Around& around) {
  std::vector<CameraFile> files(lenses.size());
  ParallelFor(static_cast<int>(lenses.size()), NumThreads(0), [&](int u) {
    const std::string path =
        prefix.empty() ? "" : prefix + std::to_string(u) + ".yaml";
    if (!path.empty() && std::filesystem::exists(path)) {
      files[u] = ReadCameraFile(path);
      return;
    }
    files[u] =
        CalibrateLens(*lenses[u], {kFleetImages}, 1000 + u, around).camera;
    if (!path.empty()) WriteFile(path, FormatCameraFile(files[u]));
  });
  return files;
}

// A family's exact middle, and its spread by many exact lenses.
Around ExactAround(const std::string& family) {
  constexpr int kMany = 200;
  const CameraModels lenses = LensesOf(family, 9);
  std::vector<CameraFile> files(kMany);
  for (CameraFile& file : files) file.camera = lenses.draw();
  CameraFile middle;
  middle.camera = lenses.middle;
  middle.spread = EstimatePopulationCovariance(*lenses.middle, files);
  return AroundOf(middle);
}

struct Options {
  std::string family = "rich", units_family, keep;
  int fleet = 40, units = 8;
  std::vector<int> images = {10};
  double part = 1, times = 1;
  bool again = false, alone = true, exact = true, plain = true;
};

void Run(const Options& options) {
  const CameraModels family = LensesOf(options.family, 1);
  const bool are_of_fleet = options.units_family.empty() && options.times == 1;
  const CameraModels strangers = LensesOf(
      options.units_family.empty() ? options.family : options.units_family, 77,
      options.times);
  std::vector<std::unique_ptr<CameraModel>> lenses, others;
  for (int u = 0; u < options.fleet; ++u) lenses.push_back(family.draw());
  for (int u = 0; u < options.units; ++u)
    others.push_back(are_of_fleet ? family.draw() : strangers.draw());
  const auto measure = [&](const std::string& name, const Around& around) {
    for (const int num_images : options.images)
      Measure(name, others, {num_images, options.part}, around);
  };
  const auto measure_both = [&](const std::string& name, const Around& around) {
    if (options.plain) measure(name, {around.camera});
    measure(name + ", spread", around);
  };
  if (options.alone) measure("alone", {});
  if (options.exact) measure_both("exact middle", ExactAround(options.family));
  if (options.fleet == 0) return;
  const std::string prefix =
      options.keep.empty() ? "" : options.keep + "/" + options.family + "-";
  std::vector<CameraFile> files = CalibrateFleet(lenses, prefix, {});
  MeasureFleet(lenses, files);
  const Around middle = AroundOf(*ComputeMeanCamera(files));
  measure_both("fleet's middle", middle);
  if (!options.again) return;
  files =
      CalibrateFleet(lenses, prefix.empty() ? "" : prefix + "again-", middle);
  MeasureFleet(lenses, files);
  measure_both("fleet again", AroundOf(*ComputeMeanCamera(files)));
}

}  // namespace
}  // namespace raygrid

int main(int argc, char** argv) {
  CLI::App app;
  raygrid::Options options;
  app.add_option("--family", options.family,
                 "simple, rich, bumpy: 100 degrees and bumps; decentred");
  app.add_option("--fleet", options.fleet, "units of the fleet");
  app.add_option("--units", options.units, "other units, with few images");
  app.add_option("--images", options.images, "of each of these");
  app.add_option("--keep", options.keep,
                 "folder in which the fleet's cameras are kept");
  app.add_option("--part", options.part,
                 "of the images' width and height that features are in");
  app.add_option("--units-family", options.units_family,
                 "of the other units: strangers");
  app.add_option("--times", options.times,
                 "strangers, which differ so many times as much");
  app.add_flag("!--no-alone", options.alone, "not without --prior");
  app.add_flag("!--no-exact", options.exact, "not around the exact middle");
  app.add_flag("!--no-plain", options.plain,
               "around middles with their spread only");
  app.add_flag("--again", options.again,
               "calibrate the fleet a second time, around its middle");
  CLI11_PARSE(app, argc, argv);
  raygrid::Run(options);
  return 0;
}
