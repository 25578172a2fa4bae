#include "exchange/libcamera_format.h"

#include "support.h"

namespace raygrid {
namespace {

// A tuning file of a sensor, with another module before.
constexpr char kTuning[] =
    "%YAML 1.1\n---\nversion: 1\nalgorithms:\n  - Agc:\nmodules:\n  - Other:\n"
    "  - Dewarp:\n      cm: [\n        1499.5, 0.0, 959.25,\n        0.0, "
    "1501.5, 540.75,\n        0.0, 0.0, 1.0,\n      ]\n      coefficients: [\n"
    "        -0.3, 0.1, 0.001, -0.002, 0.05,\n      ]\n...\n";

InputCamera ParseTuning(std::string text, const std::string& from = "",
                        const std::string& to = "") {
  if (!from.empty()) {
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
  }
  return ReadExchangeFile(&FindFormat("--from", "libcamera"),
                          {"f", text, "", ImageSize{1920, 1080}})
      .cameras.at(0);
}

TEST(MakeLibcameraFormat, ReadsTheModuleOfATuningFile) {
  EXPECT_EQ(RecognizeFormat(kTuning)->name, "libcamera");
  const InputCamera camera = ParseTuning(kTuning);
  EXPECT_EQ(camera.lens.external_model->name, "dewarp5");
  EXPECT_EQ(camera.lens.Value("fy"), 1501.5);
  EXPECT_EQ(camera.lens.Value("cx"), 959.25);
  EXPECT_EQ(camera.lens.Value("p2"), -0.002);
  EXPECT_EQ(camera.lens.Value("k3"), 0.05);
  ExpectError(ExitCode::kInvalidInput, {"--image-size"}, [] {
    ReadExchangeFile(RecognizeFormat(kTuning), {"f", kTuning, "", {}});
  });
}

TEST(MakeLibcameraFormat, SaysWhatItDoesNotTake) {
  const auto refused = [](const std::vector<std::string>& words,
                          const std::string& from, const std::string& to) {
    ExpectError(ExitCode::kInvalidInput, words,
                [&] { ParseTuning(kTuning, from, to); });
  };
  refused({"modules", "Dewarp"}, "Dewarp", "Other");
  refused({"cm"}, "0.0, 0.0, 1.0", "0.0, 1.0");
  refused({"coefficients", "6 coefficients"}, "0.05,", "0.05, 0.1,");
}

TEST(MakeLibcameraFormat, KeepsTheNameAndTheSize) {
  OutputCamera camera;
  camera.name = "front";
  camera.serial = "A 1";
  camera.lens = ParseTuning(kTuning).lens;
  const std::string text = MakeLibcameraFormat().write({"f.yaml", {camera}});
  const InputCamera back =
      ReadExchangeFile(nullptr, {"f.yaml", text, "", {}}).cameras.at(0);
  EXPECT_EQ(back.name, "front");
  EXPECT_EQ(back.serial, "A 1");
  EXPECT_EQ(back.lens.size, (ImageSize{1920, 1080}));
  EXPECT_EQ(back.lens.values, camera.lens.values);
}

}  // namespace
}  // namespace raygrid
