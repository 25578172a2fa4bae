/// Facts of every format: a new row of the table is tested by itself.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "camera/model_registry.h"
#include "camera/thin_prism_fisheye.h"
#include "exchange/damaged_files.h"
#include "exchange/format.h"
#include "exchange/unit_grid.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr ImageSize kExampleImage = {640, 480};

// A lens of a form, every parameter at work, with digits to lose.
ConvertedCamera ExampleOf(const ExternalModel& external_model) {
  const Eigen::Vector2d center =
      ToProgram(external_model.origin, kExampleImage, {958.0 / 3, 721.0 / 3});
  const std::map<std::string, double> values = {
      {"f", 700.0 / 3},   {"fx", 700.0 / 3},  {"fy", 701.0 / 3},
      {"cx", center.x()}, {"cy", center.y()}, {"xi", -0.7 / 3},
      {"alpha", 1.8 / 3}, {"beta", 3.1 / 3}};
  ConvertedCamera lens = {&external_model, kExampleImage, {}};
  const ThinPrismFisheye fisheye(kExampleImage, WholeImage(kExampleImage),
                                 {233, 234, 319, 240, 0.02, -0.01});
  if (external_model.IsSpline()) {
    lens.spline = FitSplinedStereographic(fisheye, nullptr);
    return lens;
  }
  if (external_model.fit_grid) {
    lens.grid = external_model.fit_grid(fisheye, nullptr).camera;
    return lens;
  }
  if (external_model.IsGrid()) {
    lens.grid = std::make_shared<UnitGrid>(
        FitUnitGrid(FittedGrid(fisheye, 80), external_model.HasLines()));
    return lens;
  }
  double next = 0.01 / 3;
  for (const std::string& parameter : external_model.parameters) {
    const auto known = values.find(parameter);
    lens.values.push_back(known != values.end() ? known->second : next);
    if (known == values.end()) next /= -1.7;
  }
  return lens;
}

// Cameras of every form that a format holds, and a file of it for each.
std::vector<std::pair<OutputCamera, std::string>> Examples(
    const Format& format) {
  std::vector<std::pair<OutputCamera, std::string>> examples;
  for (const ExternalModel& external_model : format.external_models) {
    OutputCamera camera;
    camera.name = "front";
    camera.lens = ExampleOf(external_model);
    camera.valid_region = ValidityMask::Over(kExampleImage);
    camera.valid_region->is_valid[70] = true;
    examples.emplace_back(camera, format.write({"front.yaml", {camera}}));
  }
  return examples;
}

TEST(GetFormats, HaveNamesOfTheirOwnAndModelsThatAreKnown) {
  std::map<std::string, int> names;
  for (const Format& format : GetFormats()) {
    EXPECT_EQ(names[format.name]++, 0) << format.name;
    EXPECT_FALSE(format.holds.empty());
    EXPECT_TRUE(format.read || format.write) << format.name;
    for (const ExternalModel& external_model : format.external_models) {
      if (external_model.IsSpline() || external_model.IsGrid()) continue;
      const ModelInfo* model = FindModelInfo(external_model.model);
      ASSERT_NE(model, nullptr) << external_model.model;
      for (const std::string& parameter : external_model.parameters)
        EXPECT_TRUE(parameter == "f" ||
                    std::count(model->parameters.begin(),
                               model->parameters.end(), parameter) == 1)
            << external_model.name << ": " << parameter;
    }
  }
  ExpectError(ExitCode::kUsage, {"--to", "none", "opencv"},
              [] { FindFormat("--to", "none"); });
}

// The size of images, if the files of a format do not say it.
std::optional<ImageSize> SizeToSay(const Format& format) {
  return format.requires_image_size ? std::optional(kExampleImage)
                                    : std::nullopt;
}

// Lengths there are parts of the image, so the last bits of parameters differ.
const std::set<std::string> kOfParts = {"opensfm", "lensfun"};

TEST(GetFormats, ReadWhatTheyWriteToTheBit) {
  constexpr double kLastBits = 1e-13;
  for (const Format& format : GetFormats()) {
    if (!format.read || !format.write) continue;
    for (const auto& [camera, text] : Examples(format)) {
      SCOPED_TRACE(format.name + " " + camera.lens.external_model->name);
      const ExchangeContents read = ReadExchangeFile(
          nullptr, {"front.yaml", text, "", SizeToSay(format)});
      ASSERT_EQ(read.cameras.size(), 1u);
      if (camera.lens.external_model->IsGrid())
        continue;  // nearly, as its test says
      const Eigen::VectorXd parameters =
          MakeCameraModel(read.cameras[0].lens)->Parameters();
      const Eigen::VectorXd expected =
          MakeCameraModel(camera.lens)->Parameters();
      if (kOfParts.count(format.name) > 0)
        EXPECT_LT((parameters - expected).norm(), kLastBits * expected.norm());
      else
        EXPECT_EQ(parameters, expected);
      EXPECT_EQ(read.cameras[0].lens.size, kExampleImage);
      EXPECT_TRUE(read.warnings.empty());
      ASSERT_EQ(read.cameras[0].valid_region.has_value(),
                format.supports_region);
      if (!format.supports_region) continue;
      EXPECT_EQ(read.cameras[0].valid_region->is_valid,
                camera.valid_region->is_valid);
    }
  }
}

TEST(GetFormats, AreReadBehindAByteOrderMark) {
  for (const Format& format : GetFormats()) {
    if (!format.read || !format.write ||
        format.external_models.front().IsGrid())
      continue;
    const auto [camera, text] = Examples(format).front();
    SCOPED_TRACE(format.name);
    const ExchangeContents read = ReadExchangeFile(
        nullptr, {"front.yaml", "\xef\xbb\xbf" + text, "", SizeToSay(format)});
    EXPECT_EQ(MakeCameraModel(read.cameras.at(0).lens)->Name(),
              MakeCameraModel(camera.lens)->Name());
  }
}

TEST(GetFormats, AreToldApart) {
  for (const Format& format : GetFormats()) {
    if (!format.write) continue;
    for (const auto& [camera, text] : Examples(format)) {
      for (const Format& other : GetFormats()) {
        EXPECT_EQ(other.recognizes && other.recognizes(text), &other == &format)
            << text << " for " << other.name;
        if (&other == &format) continue;
        ExpectError(ExitCode::kInvalidInput,
                    {"front.yaml", format.name, other.name}, [&, &text = text] {
                      ReadExchangeFile(&other, {"front.yaml", text, "", {}});
                    });
      }
    }
  }
  EXPECT_EQ(RecognizeFormat("raygrid_camera: 1\n"), nullptr);
  EXPECT_EQ(RecognizeFormat(""), nullptr);
  ExpectError(ExitCode::kInvalidInput, {"x.yaml", "supported format"}, [] {
    ReadExchangeFile(nullptr, {"x.yaml", "hello", "", {}});
  });
}

// A place in a format's file at which a key of the camera may stand, and how a
// key and a number are written there.
struct PlaceOfKey {
  std::string before, key;
};
const std::map<std::string, PlaceOfKey> kPlaces = {
    {"opencv", {"camera_matrix:", "{}: {}\n"}},
    {"ros", {"camera_matrix:", "{}: {}\n"}},
    {"kalibr", {"  camera_model:", "  {}: {}\n"}},
    {"mrcal", {"    'imagersize'", "    '{}': {},\n"}},
    {"basalt", {"\"fx\"", "\"{}\": {}, "}},
    {"nerfstudio", {"\"fl_x\"", "\"{}\": {}, "}},
    {"metashape", {"<width>", "<{0}>{1}</{0}>"}},
    {"puzzlepaint", {"width :", "{} : {}\n"}},
    {"depthai", {"\"cameraType\"", "\"{}\": {}, "}},
    {"libcamera", {"coefficients:", "{}: {}\n      "}},
    {"photonvision", {"\"resolution\"", "\"{}\": {}, "}},
    {"gyroflow", {"\"calib_dimension\"", "\"{}\": {}, "}},
    {"orbslam", {"Camera.fx:", "{}: {}\n"}},
    {"camodocal", {"image_width:", "{}: {}\n"}},
    {"euroc", {"resolution:", "{}: {}\n"}},
    {"anipose", {"matrix =", "{} = {}\n"}},
    {"okvis", {"focal_length:", "{}: {}, "}},
    {"opensfm", {"\"width\"", "\"{}\": {}, "}},
    {"kitti", {"S_00:", "{}: {}\n"}},
    {"kitti-rectified", {"P0:", "{}: {}\n"}},
    {"lensfun", {"<type>", "<{0}>{1}</{0}>"}}};

// Lines of their files have no keys, or their keys no values of one word.
const std::set<std::string> kWithoutKeys = {"colmap", "ros-ini", "calib-line",
                                            "dso", "ocamcalib"};

// A key that is not known is named; one that elsewhere selects a model, or is a
// number of one, is an error, unless it is the format's own for that.
TEST(GetFormats, LeaveNoKeyOutWithoutAWord) {
  for (const Format& format : GetFormats()) {
    if (!format.read || !format.write || kWithoutKeys.count(format.name) > 0)
      continue;
    ASSERT_EQ(kPlaces.count(format.name), 1u) << format.name;
    const PlaceOfKey& place = kPlaces.at(format.name);
    const auto [camera, text] = Examples(format).front();
    const auto read_with = [&, &text = text](const char* key,
                                             const char* value) {
      const std::string changed = TextWith(
          text, place.before,
          fmt::format(fmt::runtime(place.key), key, value) + place.before);
      return ReadExchangeFile(nullptr,
                              {"front.yaml", changed, "", SizeToSay(format)});
    };
    SCOPED_TRACE(format.name);
    const ExchangeContents stranger = read_with("stranger", "5");
    ASSERT_FALSE(stranger.warnings.empty());
    EXPECT_NE(stranger.warnings[0].find("stranger"), std::string::npos);
    for (const auto& [key, value] : {std::pair("mirror_parameters", "1.5"),
                                     {"lens_type", "\"catadioptric\""},
                                     {"projection_type", "\"double_sphere\""},
                                     {"affine", "0.1"}})
      ExpectError(ExitCode::kInvalidInput, {"front.yaml", key},
                  [&, &k = key, &v = value] { read_with(k, v); });
    const size_t usual =
        ReadExchangeFile(nullptr, {"front.yaml", text, "", SizeToSay(format)})
            .warnings.size();
    for (const auto& [key, value] :
         {std::pair("mirror_parameters", "0.0"), {"affine", "0"}})
      EXPECT_EQ(read_with(key, value).warnings.size(), usual) << key;
  }
}

// An option adds to a file, and replaces nothing that the file says.
TEST(GetFormats, RefuseOptionsAgainstTheFile) {
  for (const Format& format : GetFormats()) {
    if (!format.read || !format.write || format.requires_image_size) continue;
    const auto [camera, text] = Examples(format).back();
    SCOPED_TRACE(format.name);
    const auto read_with = [&, &text = text](const std::string& external_model,
                                             std::optional<ImageSize> size) {
      return ReadExchangeFile(nullptr,
                              {"front.yaml", text, external_model, size});
    };
    ExpectError(ExitCode::kInvalidInput,
                {"front.yaml", "320x240", "640x480", "--mode"}, [&] {
                  read_with("", ImageSize{320, 240});
                });
    EXPECT_EQ(read_with("", kExampleImage).cameras[0].lens.size, kExampleImage);
    for (const ExternalModel& other : format.external_models)
      if (FindModelInfo(other.model) &&
          other.model != camera.lens.external_model->model)
        ExpectError(ExitCode::kInvalidInput,
                    {"front.yaml", "--model " + other.name},
                    [&] { read_with(other.name, {}); });
  }
}

// Grids are fitted, which takes longer: usually a quarter.
int NumMutantsOf(const Format& format) {
  const ExternalModel& external_model = format.external_models.front();
  return NumMutants(external_model.fit_grid   ? 20
                    : external_model.IsGrid() ? 100
                                              : 400);
}

// Each is refused with one line, or is a camera of numbers.
TEST(GetFormats, TakeDamagedFilesForNothingElse) {
  TestRandom random(5);
  int num_refused = 0, num_read = 0;
  for (const Format& format : GetFormats()) {
    if (!format.read || !format.write) continue;
    const auto examples = Examples(format);
    for (int k = NumMutantsOf(format); k-- > 0; ++num_read) {
      const std::string text =
          Mutated(examples[k % examples.size()].second, &random);
      num_refused += IsRefused([&] {
        ExpectFinite(ReadExchangeFile(
            &format, {"front.yaml", text, "", SizeToSay(format)}));
      });
    }
  }
  EXPECT_GT(num_refused, num_read / 4);
}

}  // namespace
}  // namespace raygrid
