/// Facts of every format: a new row of the table is tested by itself.
#include <algorithm>
#include <map>

#include "camera/lens_models.h"
#include "camera/thin_prism_fisheye.h"
#include "exchange/damaged_files.h"
#include "exchange/format.h"
#include "exchange/unit_grid.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr ImageSize kExampleImage = {640, 480};

// A lens of a form, every parameter at work, with digits to lose.
LensInForm ExampleOf(const LensForm& form) {
  const Eigen::Vector2d center =
      ToProgram(form.origin, kExampleImage, {958.0 / 3, 721.0 / 3});
  const std::map<std::string, double> values = {
      {"f", 700.0 / 3},   {"fx", 700.0 / 3},  {"fy", 701.0 / 3},
      {"cx", center.x()}, {"cy", center.y()}, {"xi", -0.7 / 3},
      {"alpha", 1.8 / 3}, {"beta", 3.1 / 3}};
  LensInForm lens = {&form, kExampleImage, {}};
  const ThinPrismFisheye fisheye(kExampleImage, WholeImage(kExampleImage),
                                 {233, 234, 319, 240, 0.02, -0.01});
  if (form.IsSpline()) {
    lens.spline = FitSplinedStereographic(fisheye, nullptr);
    return lens;
  }
  if (form.IsGrid()) {
    lens.grid = std::make_shared<UnitGrid>(
        FitUnitGrid(FittedGrid(fisheye, 80), form.HasLines()));
    return lens;
  }
  double next = 0.01 / 3;
  for (const std::string& parameter : form.parameters) {
    const auto known = values.find(parameter);
    lens.values.push_back(known != values.end() ? known->second : next);
    if (known == values.end()) next /= -1.7;
  }
  return lens;
}

// Cameras of every form that a format holds, and a file of it for each.
std::vector<std::pair<WrittenLens, std::string>> Examples(
    const Format& format) {
  std::vector<std::pair<WrittenLens, std::string>> examples;
  for (const LensForm& form : format.forms) {
    WrittenLens camera;
    camera.name = "front";
    camera.lens = ExampleOf(form);
    camera.trusted = TrustMask::Over(kExampleImage);
    camera.trusted->is_trusted[70] = true;
    examples.emplace_back(camera, format.write({"front.yaml", {camera}}));
  }
  return examples;
}

TEST(Formats, HaveNamesOfTheirOwnAndModelsThatAreKnown) {
  std::map<std::string, int> names;
  for (const Format& format : Formats()) {
    EXPECT_EQ(names[format.name]++, 0) << format.name;
    EXPECT_FALSE(format.holds.empty());
    EXPECT_TRUE(format.read || format.write) << format.name;
    for (const LensForm& form : format.forms) {
      if (form.IsSpline() || form.IsGrid()) continue;
      const LensModel* model = FindLensModel(form.model);
      ASSERT_NE(model, nullptr) << form.model;
      for (const std::string& parameter : form.parameters)
        EXPECT_TRUE(parameter == "f" ||
                    std::count(model->parameters.begin(),
                               model->parameters.end(), parameter) == 1)
            << form.name << ": " << parameter;
    }
  }
  ExpectError(ExitCode::kUsage, {"--to", "none", "opencv"},
              [] { FindFormat("--to", "none"); });
}

TEST(Formats, ReadWhatTheyWriteToTheBit) {
  for (const Format& format : Formats()) {
    if (!format.read || !format.write) continue;
    for (const auto& [camera, text] : Examples(format)) {
      SCOPED_TRACE(format.name + " " + camera.lens.form->name);
      const ExchangeContents read =
          ReadExchangeFile(nullptr, {"front.yaml", text, "", std::nullopt});
      ASSERT_EQ(read.cameras.size(), 1u);
      if (camera.lens.form->IsGrid()) continue;  // nearly, as its test says
      EXPECT_EQ(MakeLens(read.cameras[0].lens)->Parameters(),
                MakeLens(camera.lens)->Parameters());
      EXPECT_EQ(read.cameras[0].lens.size, kExampleImage);
      EXPECT_TRUE(read.remarks.empty());
      ASSERT_EQ(read.cameras[0].trusted.has_value(), format.holds_region);
      if (!format.holds_region) continue;
      EXPECT_EQ(read.cameras[0].trusted->is_trusted,
                camera.trusted->is_trusted);
    }
  }
}

TEST(Formats, AreToldApart) {
  for (const Format& format : Formats()) {
    if (!format.write) continue;
    for (const auto& [camera, text] : Examples(format)) {
      for (const Format& other : Formats()) {
        EXPECT_EQ(other.recognizes && other.recognizes(text), &other == &format)
            << text << " for " << other.name;
        if (&other == &format) continue;
        ExpectError(ExitCode::kInput, {"front.yaml", format.name, other.name},
                    [&, &text = text] {
                      ReadExchangeFile(&other, {"front.yaml", text, "", {}});
                    });
      }
    }
  }
  EXPECT_EQ(RecognizeFormat("raygrid_camera: 1\n"), nullptr);
  EXPECT_EQ(RecognizeFormat(""), nullptr);
  ExpectError(ExitCode::kInput, {"x.yaml", "of no format"}, [] {
    ReadExchangeFile(nullptr, {"x.yaml", "hello", "", {}});
  });
}

// Grids are fitted, which takes longer: usually a quarter.
int NumMutantsOf(const Format& format) {
  return NumMutants(format.forms.front().IsGrid() ? 100 : 400);
}

// Each is refused with one line, or is a camera of numbers.
TEST(Formats, TakeDamagedFilesForNothingElse) {
  TestRandom random(5);
  int num_refused = 0, num_read = 0;
  for (const Format& format : Formats()) {
    if (!format.read || !format.write) continue;
    const auto examples = Examples(format);
    for (int k = NumMutantsOf(format); k-- > 0; ++num_read) {
      const std::string text =
          Mutated(examples[k % examples.size()].second, &random);
      num_refused += IsRefused([&] {
        ExpectFinite(ReadExchangeFile(&format, {"front.yaml", text, "", {}}));
      });
    }
  }
  EXPECT_GT(num_refused, num_read / 4);
}

}  // namespace
}  // namespace raygrid
