#include "dataset/rig_file.h"

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
    ExpectError(ExitCode::kInput, {"rig.yaml"}, [&] { ReadRigText(text); });
}

}  // namespace
}  // namespace raygrid
