// The frames of random calibrations: how far each is turned from that of the
// nearest parametric lens, and where the middle of the image looks. Run by
// hand:
//   camera_frame_bench [--count N] [--first N] [--seed N]

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "calibration/calibration.h"
#include "camera/camera_frame.h"
#include "camera/model_fitting.h"
#include "dataset/error.h"
#include "simulation/random.h"
#include "simulation/simulated_camera_models.h"
#include "simulation/simulated_rig.h"

namespace raygrid {
namespace {

constexpr double kDegreesPerRad = 180 / M_PI;

struct Case {
  std::string lens, model;
  ImageSize size;
  int num_images = 0, num_boards = 0;
  double bend_m = 0, noise_px = 0, knot_spacing_px = 0;
};

Case RandomCase(Random* random) {
  static const std::vector<std::string> lenses = {
      "pinhole",    "example",    "wide", "fisheye",
      "fisheye190", "noncentral", "glass"};
  static const std::vector<std::string> models = {
      "central-generic", "noncentral-generic", "central-radial",
      "thin-prism-fisheye", "opencv"};
  static const std::vector<ImageSize> sizes = {
      {640, 480}, {480, 640}, {800, 600}, {1280, 800}};
  Case c;
  c.lens = lenses[random->Index(static_cast<int>(lenses.size()))];
  c.model = models[random->Index(static_cast<int>(models.size()))];
  c.size = c.lens == "example"
               ? sizes[0]
               : sizes[random->Index(static_cast<int>(sizes.size()))];
  c.num_images = static_cast<int>(
      std::lround(std::exp(random->Uniform(std::log(8.0), std::log(100.0)))));
  c.num_boards = 1 + random->Index(3);
  c.bend_m = random->Index(2) == 0 ? 0 : random->Uniform(0.0003, 0.003);
  c.noise_px = std::exp(random->Uniform(std::log(0.003), std::log(0.2)));
  c.knot_spacing_px =
      c.size.width / std::vector<double>{4, 8, 16}[random->Index(3)];
  return c;
}

Pattern Boards(int count) {
  Pattern pattern = ChessboardPattern(18, 13, 0.02);
  for (int id = 1; id < count; ++id) {
    pattern.boards.push_back(pattern.boards.front());
    pattern.boards.back().id = id;
  }
  return pattern;
}

struct Frame {
  double turn_deg = 0;  // from the nearest lens
  double axis_deg = 0;  // from z to where the middle of the image looks
  double fit_deg[3] = {0, 0, 0};  // that `fit` needs
};

double AngleDeg(const Eigen::Quaterniond& rotation) {
  return kDegreesPerRad *
         rotation.angularDistance(Eigen::Quaterniond::Identity());
}

Frame FrameOf(const CameraModel& camera) {
  Frame frame;
  frame.turn_deg = kDegreesPerRad * ComputeCameraFrame(camera).AngleRad();
  if (const auto ray = camera.Unproject(camera.area().center()))
    frame.axis_deg = kDegreesPerRad * std::acos(std::min(1.0, ray->z()));
  int index = 0;
  for (const char* model : {"opencv", "thin-prism-fisheye", "central-radial"})
    frame.fit_deg[index++] = AngleDeg(
        FitNearestModel(model, camera, camera.area()).model_from_camera);
  return frame;
}

void Run(int count, int first, uint64_t seed) {
  Random random(seed);
  double worst_deg = 0;
  int num_failed = 0;
  std::printf(
      "lens model size images boards bend noise cell: held-out, turn, "
      "axis, fit opencv thin-prism radial\n");
  for (int i = 0; i < first + count; ++i) {
    const Case c = RandomCase(&random);
    if (i < first) continue;
    std::printf("%s %s %dx%d %d %d %.4f %.3f %.0f: ", c.lens.c_str(),
                c.model.c_str(), c.size.width, c.size.height, c.num_images,
                c.num_boards, c.bend_m, c.noise_px, c.knot_spacing_px);
    SimulationOptions simulation;
    simulation.num_images = (c.num_images + c.num_boards - 1) / c.num_boards;
    simulation.features_per_image = 120;
    simulation.noise_px = c.noise_px;
    simulation.board_sagitta_m = c.bend_m;
    simulation.seed = seed + i;
    const Pattern pattern = Boards(c.num_boards);
    CalibrationOptions options;
    options.model = c.model;
    options.knot_spacing_px = c.knot_spacing_px;
    try {
      const Dataset dataset =
          SimulateRig(MakeCameraRow(MakeSimulatedCamera(c.lens, c.size), 1, 0),
                      pattern, simulation)
              .datasets.front();
      options.hold_out = {dataset.images.front().image};
      const CalibrationResult result = Calibrate(dataset, pattern, options);
      const Frame frame = FrameOf(*result.camera.camera);
      worst_deg = std::max(worst_deg, frame.turn_deg);
      std::printf("%.4f px, %.5f, %.2f, %.3f %.3f %.3f%s\n",
                  result.camera.held_out->median_px, frame.turn_deg,
                  frame.axis_deg, frame.fit_deg[0], frame.fit_deg[1],
                  frame.fit_deg[2], result.converged ? "" : " not converged");
    } catch (const Error& error) {
      ++num_failed;
      std::printf("%s\n", error.what());
    }
    std::fflush(stdout);
  }
  std::printf(
      "%d calibrations, %d failed; the frame turned by at most %.5f "
      "degrees\n",
      count, num_failed, worst_deg);
}

}  // namespace
}  // namespace raygrid

int main(int argc, char** argv) {
  int count = 200, first = 0;
  uint64_t seed = 1;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--count") == 0)
      count = std::atoi(argv[i + 1]);
    else if (std::strcmp(argv[i], "--first") == 0)
      first = std::atoi(argv[i + 1]);
    else if (std::strcmp(argv[i], "--seed") == 0)
      seed = std::strtoull(argv[i + 1], nullptr, 10);
  }
  raygrid::Run(count, first, seed);
  return 0;
}
