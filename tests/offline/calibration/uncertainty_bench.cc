// How the predicted uncertainty of cameras agrees with how they scatter over
// draws of the noise, and with the truth. Run by hand:
//   uncertainty_bench [--images N] [--draws N] [--seed N] [--cell PX]...

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "adjustment/covariance.h"
#include "calibration/camera_adjustment.h"
#include "calibration/camera_initialization.h"
#include "calibration/model_adjustment.h"
#include "calibration/uncertainty_estimation.h"
#include "dataset/parallel_for.h"
#include "evaluation/model_difference.h"
#include "evaluation/residual_statistics.h"
#include "simulation/random.h"
#include "simulation/simulated_camera.h"
#include "simulation/simulated_observations.h"

namespace raygrid {
namespace {

constexpr double kNoisePx = 0.05;

double Now() {
  return std::chrono::duration<double>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

struct Draw {
  std::vector<PixelUncertainty> predicted;
  std::vector<Eigen::Vector2d> errors;  // where predicted
  std::vector<bool> valid_region;
  double noise_px = 0, weight = 0, worst_px = 0;
  double seconds = 0, covariance_seconds = 0;
};

// The variance that camera.yaml states of trusted pixels.
double StatedPx2(const PixelUncertainty& pixel) {
  return pixel.noise_px2.trace() + pixel.smoothing_px.squaredNorm();
}

Draw CalibrateDraw(const Pattern& pattern, const AdjustmentResult& start,
                   double knot_spacing_px, int seed) {
  const SimulatedCamera truth = ExampleSimulatedCamera();
  AdjustmentOptions options;
  options.num_threads = 1;
  AdjustmentResult adjusted = start;
  Random random(seed);
  for (View& view : adjusted.problem.views)
    for (Observation& o : view.observations)
      o.pixel += kNoisePx * Eigen::Vector2d(random.Normal(), random.Normal());
  const double begin = Now();
  RefineCameras(adjusted.problem, options, &adjusted.state);
  OptimizeModel(pattern, "central-generic", {knot_spacing_px}, options,
                &adjusted);
  Draw draw;
  draw.seconds = Now() - begin;
  draw.noise_px = adjusted.summary.noise_px;
  draw.weight = adjusted.prior.cameras[0].groups[0].weight;
  options.fix_points = true;
  const double middle = Now();
  const LinearResponse response(adjusted.problem.views, adjusted.prior, options,
                                adjusted.state);
  draw.predicted =
      EstimateProjectionUncertainty(response, draw.noise_px, nullptr,
                                    adjusted.problem.views, adjusted.state, 0);
  draw.covariance_seconds = Now() - middle;
  const ValidityMask mask =
      EstimateUncertainty(adjusted, 0, {}, {}, 1).value().uncertainty.mask;
  for (const PixelUncertainty& p : draw.predicted)
    draw.valid_region.push_back(mask.IsValidAt(p.pixel));
  const CameraModel& camera = adjusted.state.camera();
  const ModelDifference difference = CompareModels(truth, camera, 8);
  for (size_t i = 0; i < difference.pixels.size(); ++i)
    if (mask.IsValidAt(difference.pixels[i]))
      draw.worst_px = std::max(draw.worst_px, difference.error_px[i].norm());
  const Eigen::Quaterniond turn = difference.first_from_second.rotation;
  for (const PixelUncertainty& p : draw.predicted)
    draw.errors.push_back(
        truth.Project(turn * camera.Unproject(p.pixel).value(), &p.pixel, 50)
            .value() -
        p.pixel);
  return draw;
}

void RunCells(int num_images, int num_draws, int seed, double knot_spacing_px) {
  const Pattern pattern = ChessboardPattern(30, 24, 0.02);
  SimulationOptions simulation;
  simulation.num_images = num_images;
  simulation.noise_px = 0;
  AdjustmentOptions options;
  const AdjustmentResult start = InitializeCamera(
      SimulateObservations(ExampleSimulatedCamera(), pattern, simulation)
          .dataset,
      pattern, options);
  std::vector<Draw> draws(num_draws);
  ParallelFor(num_draws, NumThreads(0), [&](int i) {
    draws[i] = CalibrateDraw(pattern, start, knot_spacing_px, 1000 * seed + i);
  });

  const size_t num_pixels = draws[0].predicted.size();
  std::vector<double> ratios, stated_ratios, total_ratios, bias_ratios, worst;
  int num_trusted = 0;
  double mean_sum = 0, scatter_sum = 0, expected_sum = 0;
  for (size_t i = 0; i < num_pixels; ++i) {
    int count = 0;
    for (const Draw& draw : draws) count += draw.valid_region[i];
    if (2 * count < num_draws) continue;
    ++num_trusted;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (const Draw& draw : draws) mean += draw.errors[i] / num_draws;
    double scatter = 0, predicted = 0, stated = 0, total = 0;
    for (const Draw& draw : draws) {
      scatter += (draw.errors[i] - mean).squaredNorm() / (num_draws - 1);
      predicted += draw.predicted[i].noise_px2.trace() / num_draws;
      stated += StatedPx2(draw.predicted[i]) / num_draws;
      total += draw.predicted[i].total_px2.trace() / num_draws;
    }
    mean_sum += mean.squaredNorm(), scatter_sum += scatter;
    expected_sum += predicted;
    ratios.push_back(std::sqrt(predicted / scatter));
    stated_ratios.push_back(std::sqrt(stated / scatter));
    total_ratios.push_back(std::sqrt(total / scatter));
    bias_ratios.push_back(mean.norm() / std::sqrt(predicted));
  }
  std::vector<double> rms_ratios, stated_rms_ratios, medians;
  size_t num_errors = 0;
  double sum = 0, predicted_sum = 0, stated_sum = 0, seconds = 0,
         covariance_seconds = 0;
  for (const Draw& draw : draws) {
    double own = 0, own_predicted = 0, own_stated = 0;
    std::vector<double> deviations;
    for (size_t i = 0; i < num_pixels; ++i) {
      if (!draw.valid_region[i]) continue;
      own += draw.errors[i].squaredNorm();
      ++num_errors;
      own_predicted += draw.predicted[i].noise_px2.trace();
      own_stated += StatedPx2(draw.predicted[i]);
      deviations.push_back(ComputeAxisStdDev(draw.predicted[i].noise_px2));
    }
    sum += own, predicted_sum += own_predicted, stated_sum += own_stated;
    stated_rms_ratios.push_back(std::sqrt(own / own_stated));
    rms_ratios.push_back(std::sqrt(own / own_predicted));
    worst.push_back(draw.worst_px);
    medians.push_back(Quantile(deviations, 0.5));
    seconds += draw.seconds, covariance_seconds += draw.covariance_seconds;
  }
  const auto percent_within = [](const std::vector<double>& r) {
    return 100.0 *
           std::count_if(r.begin(), r.end(),
                         [](double x) { return std::abs(x - 1) < 0.2; }) /
           r.size();
  };
  std::printf(
      "cells %3.0f px: noise %.4f, weight %.3g, trusted %d of %zu, median sd "
      "%.4f; predicted/scatter median %.3f (5 %% %.3f, 95 %% %.3f), within 20 "
      "%%: %.1f %%; stated/scatter median %.3f, within 20 %%: %.1f %%; RMS "
      "error/stated over draws %.3f, single max %.3f; total/scatter median "
      "%.3f; bias/predicted median %.2f, RMS %.2f; RMS scatter/predicted %.3f; "
      "RMS "
      "error/predicted over draws "
      "%.3f, single 90 %% %.3f max %.3f, RMS %.5f px; worst pixel median %.3f "
      "max %.3f px; "
      "%.2f s a draw, covariance %.2f s\n",
      knot_spacing_px, draws[0].noise_px, draws[0].weight, num_trusted,
      num_pixels, Quantile(medians, 0.5), Quantile(ratios, 0.5),
      Quantile(ratios, 0.05), Quantile(ratios, 0.95), percent_within(ratios),
      Quantile(stated_ratios, 0.5), percent_within(stated_ratios),
      std::sqrt(sum / stated_sum), Quantile(stated_rms_ratios, 1),
      Quantile(total_ratios, 0.5), Quantile(bias_ratios, 0.5),
      std::sqrt(mean_sum / expected_sum), std::sqrt(scatter_sum / expected_sum),
      std::sqrt(sum / predicted_sum), Quantile(rms_ratios, 0.9),
      Quantile(rms_ratios, 1), std::sqrt(sum / static_cast<double>(num_errors)),
      Quantile(worst, 0.5), Quantile(worst, 1), seconds / num_draws,
      covariance_seconds / num_draws);
  std::fflush(stdout);
}

}  // namespace
}  // namespace raygrid

int main(int argc, char** argv) {
  int num_images = 100, num_draws = 50, seed = 1;
  std::vector<double> cells;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--images") == 0)
      num_images = std::atoi(argv[i + 1]);
    else if (std::strcmp(argv[i], "--draws") == 0)
      num_draws = std::atoi(argv[i + 1]);
    else if (std::strcmp(argv[i], "--seed") == 0)
      seed = std::atoi(argv[i + 1]);
    else
      cells.push_back(std::atof(argv[i + 1]));
  }
  for (const double knot_spacing_px : cells)
    raygrid::RunCells(num_images, num_draws, seed, knot_spacing_px);
  return 0;
}
