// True errors of cameras that are calibrated from simulated observations,
// beside those of the best possible estimate. Run by hand:
//   accuracy_bench [--lens wide]... [--images 40]... [--seeds N]

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "dataset/memory_retention.h"
#include "evaluation/residual_statistics.h"
#include "true_error.h"

namespace raygrid {
namespace {

void Measure(const TrueErrorSetting& setting, int num_seeds, bool verbose) {
  std::vector<double> rms_px, max_px;
  double mean_px = 0, oracle_px = 0;
  TrueError sum;
  sum.jackknife_scale = 0;
  for (int seed = 1; seed <= num_seeds; ++seed) {
    const TrueError error = MeasureTrueError(setting, seed);
    if (verbose)
      std::printf(
          "  seed %d: RMS %.5f px, median %.5f, max %.4f, oracle %.5f; within "
          "%.2f, %.2f, ratio %.2f; trusted %.2f: %.2f, %.2f, ratio %.2f; "
          "jackknife scale %.2f\n",
          seed, error.rms_px, error.median_px, error.max_px, error.oracle_px,
          error.within_1, error.within_2, error.ratio, error.valid_fraction,
          error.trusted_within_1, error.trusted_within_2, error.trusted_ratio,
          error.jackknife_scale);
    sum.within_1 += error.within_1 / num_seeds;
    sum.within_2 += error.within_2 / num_seeds;
    sum.trusted_within_1 += error.trusted_within_1 / num_seeds;
    sum.trusted_within_2 += error.trusted_within_2 / num_seeds;
    sum.valid_fraction += error.valid_fraction / num_seeds;
    sum.jackknife_scale += error.jackknife_scale / num_seeds;
    rms_px.push_back(error.rms_px);
    max_px.push_back(error.max_px);
    mean_px += error.rms_px / num_seeds;
    oracle_px += error.oracle_px / num_seeds;
  }
  std::printf(
      "%-10s %-7s %4d images, noise %.3f px: RMS mean %.5f px, median %.5f, "
      "max %.4f, oracle %.5f (%.2f x); within 1 and 2 standard deviations "
      "%.2f, %.2f; of %.2f trusted %.2f, %.2f; jackknife scale %.2f\n",
      setting.lens.c_str(), setting.target.c_str(), setting.num_images,
      setting.noise_px, mean_px, Quantile(rms_px, 0.5), Quantile(max_px, 0.5),
      oracle_px, mean_px / oracle_px, sum.within_1, sum.within_2,
      sum.valid_fraction, sum.trusted_within_1, sum.trusted_within_2,
      sum.jackknife_scale);
  std::fflush(stdout);
}

}  // namespace
}  // namespace raygrid

int main(int argc, char** argv) {
  raygrid::RetainFreedMemory();  // as raygrid does
  CLI::App app("True errors of calibrated cameras, beside the best possible.");
  std::vector<std::string> lenses = {"wide", "narrow", "fisheye", "fisheye190",
                                     "smooth"};
  std::vector<std::string> targets = {"flat"};
  std::vector<int> images = {10, 40, 100};
  std::vector<double> noise_px = {0.05};
  raygrid::TrueErrorSetting setting;
  int num_seeds = 8;
  bool verbose = false;
  app.add_option("--lens", lenses, "families of lenses (default: all)")
      ->check(CLI::IsMember(lenses));
  app.add_option("--target", targets)
      ->check(CLI::IsMember({"flat", "bent", "bending", "correlated"}))
      ->capture_default_str();
  app.add_option("--images", images)->capture_default_str();
  app.add_option("--noise-px", noise_px)->capture_default_str();
  app.add_option("--knot-spacing-px", setting.knot_spacing_px, "0: chosen")
      ->capture_default_str();
  app.add_option("--seeds", num_seeds)->capture_default_str();
  app.add_flag("--verbose", verbose, "print each seed");
  app.add_flag("!--no-oracle", setting.with_oracle,
               "without the best possible estimate, which takes long");
  CLI11_PARSE(app, argc, argv);
  for (const std::string& lens : lenses)
    for (const std::string& target : targets)
      for (const int num_images : images)
        for (const double noise : noise_px) {
          setting.lens = lens;
          setting.target = target;
          setting.num_images = num_images;
          setting.noise_px = noise;
          raygrid::Measure(setting, num_seeds, verbose);
        }
  return 0;
}
