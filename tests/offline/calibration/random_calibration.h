#ifndef RAYGRID_TESTS_OFFLINE_CALIBRATION_RANDOM_CALIBRATION_H
#define RAYGRID_TESTS_OFFLINE_CALIBRATION_RANDOM_CALIBRATION_H

#include <cmath>
#include <memory>
#include <string>

#include "dataset/dataset.h"
#include "simulation/simulated_camera_models.h"
#include "simulation/simulated_observations.h"
#include "support.h"

namespace raygrid {

/// A parametric model to calibrate, and what a lens of another kind shows.
struct RandomCalibration {
  std::string model, lens;
  bool fix_target_geometry = false;
  Pattern pattern;
  Dataset dataset;
};

inline RandomCalibration MakeRandomCalibration(unsigned seed, int min_images,
                                               int max_images) {
  TestRandom random(seed);
  random.Index(2);  // the first number of neighbouring seeds is much alike
  RandomCalibration result;
  const char* const models[] = {"opencv", "thin-prism-fisheye",
                                "central-radial"};
  const char* const lenses[] = {"pinhole", "example", "wide", "fisheye",
                                "fisheye190"};
  result.model = models[random.Index(3)];
  result.lens = lenses[random.Index(5)];
  result.fix_target_geometry = random.Index(4) == 0;
  result.pattern = ChessboardPattern(14, 10, 0.03);
  SimulationOptions options;
  options.num_images = static_cast<int>(std::lround(
      min_images * std::pow(static_cast<double>(max_images) / min_images,
                            random.Uniform(0, 1))));
  options.features_per_image = 60 + random.Index(80);
  options.noise_px = 0.02 * std::pow(20, random.Uniform(0, 1));
  options.board_sagitta_m = 0.003 * random.Uniform(0, 1);
  options.seed = seed;
  result.dataset = SimulateObservations(
                       *MakeSimulatedCamera(result.lens, ImageSize{640, 480}),
                       result.pattern, options)
                       .dataset;
  return result;
}

}  // namespace raygrid

#endif  // RAYGRID_TESTS_OFFLINE_CALIBRATION_RANDOM_CALIBRATION_H
