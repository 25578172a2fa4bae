#include "dataset/rig_file.h"

#include <cmath>

#include "dataset/files.h"
#include "support.h"

namespace raygrid {
namespace {

std::vector<RigFileCamera> ReadRigText(const std::string& text) {
  const TemporaryFolder folder;
  WriteFile(folder / "rig.yaml", text);
  return ReadRigFile(folder / "rig.yaml");
}

std::vector<RigFileCamera> ExampleRigCameras() {
  return {{"left", "left/camera.yaml", {}},
          {"aft-2",
           "aft-2/camera.yaml",
           {RotationFromVector({0.3, -2.9, 0.5}), {-0.125, 1e-7, 2.5}}}};
}

TEST(RigFile, IsReadAsItWasWritten) {
  const auto read = ReadRigText(FormatRigFile(ExampleRigCameras()));
  const auto written = ExampleRigCameras();
  ASSERT_EQ(read.size(), 2u);
  for (int c = 0; c < 2; ++c) {
    EXPECT_EQ(read[c].name, written[c].name);
    EXPECT_EQ(read[c].file, written[c].file);
    const Pose& pose = written[c].camera_from_rig;
    EXPECT_LT((read[c].camera_from_rig.translation - pose.translation).norm(),
              1e-9);
    EXPECT_LT(read[c].camera_from_rig.rotation.angularDistance(pose.rotation),
              1e-10);
  }
}

TEST(RigFile, RefusesWhatIsMalformed) {
  const std::string good = FormatRigFile(ExampleRigCameras());
  const auto replaced = [&good](const std::string& old, const std::string& by) {
    std::string text = good;
    return text.replace(text.find(old), old.size(), by);
  };
  for (const std::string& text :
       {replaced("raygrid_rig: 1", "raygrid_rig: 2"),
        replaced("raygrid_rig", "raygrid_rag"), replaced("aft-2", "left"),
        replaced("w: 1.0", "w: 1.1"), replaced("w: 1.0", "w: .nan"),
        replaced("rotation", "turn"), replaced("translation", "shift"),
        replaced("aft-2", "../aft"), replaced("aft-2", "javascript:a//"),
        replaced("aft-2", "a\\nb"), replaced("w: 1.0", "w: 1, w: 1.0"),
        replaced("file", "path"), replaced("x: -0.125", "x: .inf"),
        std::string("raygrid_rig: 1\ncameras:\n"), std::string("- a\n"),
        std::string("raygrid_rig: [\n")})
    ExpectError(ExitCode::kInvalidInput, {"rig.yaml"},
                [&] { ReadRigText(text); });
}

PoseCovariance ExampleCovariance() {
  PoseCovariance root = PoseCovariance::Identity();
  root(0, 4) = 0.5;
  root(2, 1) = -0.25;
  const Eigen::Matrix<double, 6, 1> scale(1e-4, 2e-4, 3e-4, 1e-5, 0, 1e-3);
  return scale.asDiagonal() * PoseCovariance(root * root.transpose()) *
         scale.asDiagonal();
}

TEST(RigFile, CovariancesAreReadAsTheyWereWritten) {
  const std::string text = FormatRigFile(
      ExampleRigCameras(), {{"left", "aft-2", ExampleCovariance()}});
  EXPECT_EQ(ReadRigText(text).size(), 2u);
  const auto pairs = ParseRelativePoseCovariances("rig.yaml", text);
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].first, "left");
  EXPECT_TRUE(pairs[0].covariance.isApprox(ExampleCovariance(), 1e-8));
  EXPECT_EQ(FormatRigFile(ExampleRigCameras(), pairs), text);
  EXPECT_EQ(FindRelativePose(pairs, "aft-2", "left"), pairs.data());
  EXPECT_EQ(FindRelativePose(pairs, "aft-2", "top"), nullptr);
  EXPECT_NEAR(pairs[0].RotationStdDev(),
              std::sqrt(ExampleCovariance().topLeftCorner<3, 3>().trace()),
              1e-12);
  EXPECT_NEAR(pairs[0].DistanceStdDev({0, 0, -3}),
              std::sqrt(ExampleCovariance()(5, 5)), 1e-12);
  EXPECT_TRUE(ParseRelativePoseCovariances("rig.yaml",
                                           FormatRigFile(ExampleRigCameras()))
                  .empty());
}

TEST(RigFile, RefusesWrongCovariances) {
  const PoseCovariance good = ExampleCovariance();
  std::vector<PoseCovariance> wrong(3, good);
  wrong[0](0, 1) = 1e-7;  // not symmetric
  wrong[1](0, 0) = -wrong[1](0, 0);
  wrong[2](0, 1) = wrong[2](1, 0) = 1;  // correlation above 1
  for (const PoseCovariance& covariance : wrong)
    ExpectError(ExitCode::kInvalidInput, {"rig.yaml", "covariance"}, [&] {
      ReadRigText(
          FormatRigFile(ExampleRigCameras(), {{"left", "aft-2", covariance}}));
    });
  for (const auto& pairs : std::vector<std::vector<RelativePoseCovariance>>{
           {{"left", "top", good}},
           {{"left", "left", good}},
           {{"left", "aft-2", good}, {"aft-2", "left", good}}})
    ExpectError(ExitCode::kInvalidInput, {"relative_poses"}, [&] {
      ReadRigText(FormatRigFile(ExampleRigCameras(), pairs));
    });
  const std::string text =
      FormatRigFile(ExampleRigCameras(), {{"left", "aft-2", good}});
  const auto replaced = [&text](const std::string& by) {
    std::string changed = text;
    const size_t begin = changed.find("      - [") + 9;
    return changed.replace(begin, changed.find(',', begin) - begin, by);
  };
  ExpectError(ExitCode::kInvalidInput, {"6 rows of 6"},
              [&] { ReadRigText(replaced("1, 2")); });
  ExpectError(ExitCode::kInvalidInput, {"must be finite"},
              [&] { ReadRigText(replaced(".nan")); });
}

}  // namespace
}  // namespace raygrid
