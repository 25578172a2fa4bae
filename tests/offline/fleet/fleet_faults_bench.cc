// A fleet with faults, as features and a plan: whether calibrated units tell
// them. Run by hand; --help tells the options:
//   fleet_faults_bench FOLDER
//   raygrid batch FOLDER/plan.yaml -o FOLDER/out

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "dataset/dataset.h"
#include "dataset/files.h"
#include "simulation/asymmetric_camera.h"
#include "simulation/random.h"
#include "simulation/simulated_observations.h"

namespace raygrid {
namespace {

constexpr ImageSize kSize = {960, 600};

// A lens of the family, and how its sensor stands.
struct FamilyMember {
  double focal_px = 800, k1 = -0.2;
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  // from the middle
  double tilt_rad = 0;  // of the sensor, about its columns
};

// With (x, y) = (X, Y) / Z:
//   pixel = centre + focal (1 + k1 (x^2 + y^2)) (x, y) / (1 + tan(tilt) x)
class FamilyMemberLens : public AsymmetricCamera {
 public:
  explicit FamilyMemberLens(const FamilyMember& member)
      : AsymmetricCamera(kSize,
                         {-1, -1, 1.0 * kSize.width, 1.0 * kSize.height}),
        member_(member) {}
  std::string Name() const override { return "member of a family"; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<FamilyMemberLens>(*this);
  }

 protected:
  Eigen::Vector3d DirectionFromPosition(
      const Eigen::Vector2d& place) const override {
    constexpr int kRounds = 60;  // each leaves half of the error or less
    const Eigen::Vector2d image =
        (kSize.width * place - member_.centre_px) / member_.focal_px;
    Eigen::Vector2d ray = image;
    for (int round = 0; round < kRounds; ++round) ray = image / Scale(ray);
    return ray.homogeneous();
  }
  std::optional<Eigen::Vector2d> PositionFromDirection(
      const Eigen::Vector3d& direction) const override {
    // Beyond, distortion turns back.
    const double farthest = std::sqrt(-1 / (3 * member_.k1));
    const Eigen::Vector2d ray = direction.hnormalized();
    if (!(direction.z() > 0) || ray.norm() > farthest) return std::nullopt;
    return (member_.centre_px + member_.focal_px * Scale(ray) * ray) /
           kSize.width;
  }

 private:
  double Scale(const Eigen::Vector2d& ray) const {
    return (1 + member_.k1 * ray.squaredNorm()) /
           (1 + std::tan(member_.tilt_rad) * ray.x());
  }

  FamilyMember member_;
};

struct Options {
  std::string folder, model = "opencv";
  int units = 200, images = 10;
  double noise_px = 0.05, tilt_rad = 0.005, shift_px = 25, jump_px = 3;
  uint64_t seed = 1;
};

// Usual lenses scatter by 0.3 % in focal length, 3 px in each axis of the
// centre, and 0.004 in k1.
std::vector<FamilyMember> MakeFleet(const Options& options) {
  constexpr int kTilted[] = {17, 88, 150}, kShifted = 61, kJump = 120;
  Random random(options.seed);
  std::vector<FamilyMember> fleet(options.units);
  for (int u = 0; u < options.units; ++u) {
    FamilyMember& unit = fleet[u];
    if (u >= kJump) unit.focal_px += options.jump_px;
    unit.focal_px *= 1 + 0.003 * random.Normal();
    unit.centre_px.x() = 3 * random.Normal();
    unit.centre_px.y() = 3 * random.Normal();
    unit.k1 += 0.004 * random.Normal();
    if (std::count(std::begin(kTilted), std::end(kTilted), u))
      unit.tilt_rad = options.tilt_rad;
    if (u == kShifted) unit.centre_px.x() += options.shift_px;
  }
  return fleet;
}

void Write(const Options& options) {
  const Pattern pattern = ChessboardPattern(13, 9, 0.03);
  const std::string& folder = options.folder;
  std::filesystem::create_directories(folder);
  WriteFile(folder + "/pattern.yaml", FormatPattern(pattern));
  std::string plan = fmt::format(
      "raygrid_batch: 1\npattern: pattern.yaml\nmodel: {}\n"
      "skip_comparison: true\nfix_target_geometry: true\nimage_size: [{}, "
      "{}]\nunits:\n",
      options.model, kSize.width, kSize.height);
  const std::vector<FamilyMember> fleet = MakeFleet(options);
  for (size_t u = 0; u < fleet.size(); ++u) {
    SimulationOptions simulation;
    simulation.num_images = options.images;
    simulation.features_per_image = 60;
    simulation.noise_px = options.noise_px;
    simulation.seed = 1000 * options.seed + u;
    const std::string name = fmt::format("U{:03}", u);
    WriteFile(fmt::format("{}/{}.csv", folder, name),
              FormatFeatures(SimulateObservations(FamilyMemberLens(fleet[u]),
                                                  pattern, simulation)
                                 .dataset));
    plan += fmt::format("  - {{serial: {0}, features: {0}.csv}}\n", name);
  }
  WriteFile(folder + "/plan.yaml", plan);
}

}  // namespace
}  // namespace raygrid

int main(int argc, char** argv) {
  CLI::App app;
  raygrid::Options options;
  app.add_option("folder", options.folder, "where files are written")
      ->required();
  app.add_option("--model", options.model, "that units are calibrated with");
  app.add_option("--units", options.units, "of the fleet");
  app.add_option("--images", options.images, "of each unit");
  app.add_option("--noise-px", options.noise_px, "of features");
  app.add_option("--tilt-rad", options.tilt_rad,
                 "of the sensors of U017, U088 and U150");
  app.add_option("--shift-px", options.shift_px, "of the centre of U061");
  app.add_option("--jump-px", options.jump_px,
                 "of the mean focal length, from U120 on");
  app.add_option("--seed", options.seed, "of the fleet");
  CLI11_PARSE(app, argc, argv);
  raygrid::Write(options);
  return 0;
}
