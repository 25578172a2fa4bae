#include "exchange/metashape_format.h"

#include "support.h"

namespace raygrid {
namespace {

// A calibration as Metashape writes it.
constexpr char kMetashape[] =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<calibration>\n"
    "  <projection>frame</projection>\n  <width>4096</width>\n"
    "  <height>3072</height>\n  <f>3219.5</f>\n  <cx>15.125</cx>\n"
    "  <cy>-18.5</cy>\n  <b1>2.5</b1>\n  <b2>0</b2>\n"
    "  <k1>0.02</k1>\n  <k2>-0.07</k2>\n  <k3>0.09</k3>\n"
    "  <p1>0.0015</p1>\n  <p2>0.0017</p2>\n"
    "  <date>2024-05-06T07:08:09Z</date>\n</calibration>\n";

ExchangeContents ParseMetashape(const std::string& text) {
  return ReadExchangeFile(RecognizeFormat(text), {"f", text, "", {}});
}

std::string FisheyeCalibration() {
  return TextWith(TextWith(kMetashape, "frame", "fisheye"), "</k3>",
                  "</k3><k4>-0.01</k4>");
}

TEST(MakeMetashapeFormat, ReadsAFrame) {
  const ExchangeContents contents = ParseMetashape(kMetashape);
  ASSERT_EQ(contents.cameras.size(), 1u);
  EXPECT_TRUE(contents.warnings.empty());
  const ConvertedCamera& lens = contents.cameras[0].lens;
  EXPECT_EQ(lens.size, (ImageSize{4096, 3072}));
  const auto model = MakeCameraModel(lens);
  EXPECT_EQ(model->Name(), "opencv");
  Eigen::VectorXd expected(12);
  // fx, fy, cx, cy, k1 to k6, p1, p2
  expected << 3222, 3219.5, 2047.5 + 15.125, 1535.5 - 18.5, 0.02, -0.07, 0.09,
      0, 0, 0, 0.0017, 0.0015;
  EXPECT_EQ(model->Parameters(), expected);
}

TEST(MakeMetashapeFormat, ReadsAFisheye) {
  for (const char* name : {"fisheye", "equidistant_fisheye"}) {
    const ExchangeContents contents =
        ParseMetashape(TextWith(FisheyeCalibration(), "fisheye", name));
    const auto model = MakeCameraModel(contents.cameras[0].lens);
    EXPECT_EQ(model->Name(), "thin-prism-fisheye");
    Eigen::VectorXd expected(12);
    // fx, fy, cx, cy, k1 to k4, p1, p2, sx1, sy1
    expected << 3222, 3219.5, 2047.5 + 15.125, 1535.5 - 18.5, 0.02, -0.07, 0.09,
        -0.01, 0.0017, 0.0015, 0, 0;
    EXPECT_EQ(model->Parameters(), expected);
  }
}

TEST(MakeMetashapeFormat, WritesWhatItReads) {
  for (const std::string& text :
       {std::string(kMetashape), FisheyeCalibration()}) {
    OutputCamera camera;
    camera.lens = ParseMetashape(text).cameras[0].lens;
    camera.fit = ModelFit{};
    const std::string written =
        MakeMetashapeFormat().write({"f.xml", {camera}});
    EXPECT_EQ(ParseMetashape(written).cameras[0].lens.values,
              camera.lens.values);
    EXPECT_NE(written.find("<b1>2.5</b1>"), std::string::npos);
    EXPECT_NE(written.find("<p1>0.0015</p1>"), std::string::npos);
    EXPECT_NE(written.find("RMS"), std::string::npos);
  }
}

// The document of "Export Cameras": sensors, with what Metashape began with.
TEST(MakeMetashapeFormat, ReadsTheSensorsOfADocument) {
  const std::string begin =
      "<calibration type=\"frame\" class=\"initial\"><resolution "
      "width=\"4096\" height=\"3072\"/><f>3000</f></calibration>\n";
  const std::string adjusted =
      "<calibration type=\"frame\" class=\"adjusted\"><resolution "
      "width=\"4096\" height=\"3072\"/><f>3219.5</f><cx>15.125</cx>"
      "<cy>-18.5</cy><b1>2.5</b1><k1>0.02</k1><k2>-0.07</k2><k3>0.09</k3>"
      "<p1>0.0015</p1><p2>0.0017</p2></calibration>\n";
  const auto document = [](const std::string& calibrations) {
    return "<?xml version=\"1.0\"?>\n<document version=\"1.5.0\"><chunk>"
           "<sensors next_id=\"1\"><sensor id=\"0\" label=\"A (9 mm)\" "
           "type=\"frame\"><resolution width=\"4096\" height=\"3072\"/>" +
           calibrations + "</sensor></sensors></chunk></document>\n";
  };
  const auto read = ParseMetashape(document(begin + adjusted));
  ASSERT_EQ(read.cameras.size(), 1u);
  EXPECT_EQ(MakeCameraModel(read.cameras[0].lens)->Parameters(),
            MakeCameraModel(ParseMetashape(kMetashape).cameras[0].lens)
                ->Parameters());
  const auto first = ParseMetashape(document(begin));
  EXPECT_EQ(first.cameras.at(0).lens.Value("fy"), 3000);
  EXPECT_EQ(first.warnings.size(), 2u);
  ExpectError(ExitCode::kInvalidInput, {"f: contains no camera"},
              [&] { ParseMetashape(document("")); });
}

// b2 is a skew: x + b2 y.
TEST(MakeMetashapeFormat, ReadsASkewAsAGrid) {
  const auto read = ParseMetashape(TextWith(kMetashape, "<b2>0", "<b2>-4.25"));
  const auto grid = MakeCameraModel(read.cameras.at(0).lens);
  const auto straight =
      MakeCameraModel(ParseMetashape(kMetashape).cameras[0].lens);
  const double cy = straight->Parameters()[3], fy = straight->Parameters()[1];
  for (const double y : {-0.3, 0.0, 0.35}) {
    const Eigen::Vector3d point(0.2, y, 1);
    Eigen::Vector2d expected = straight->Project(point).value();
    expected.x() += -4.25 * (expected.y() - cy) / fy;
    EXPECT_LT((grid->Project(point).value() - expected).norm(), 0.01);
  }
}

TEST(MakeMetashapeFormat, SaysWhatIsMissingOrWrong) {
  const auto expect = [](const std::string& old, const std::string& by,
                         const std::vector<std::string>& words) {
    ExpectError(ExitCode::kInvalidInput, words,
                [&] { ParseMetashape(TextWith(kMetashape, old, by)); });
  };
  expect("frame", "equisolid_fisheye",
         {"f: unsupported projection", "fisheye"});
  expect("</k3>", "</k3><k4>0.1</k4>", {"k4 of a frame"});
  expect("</k3>", "</k3><p3>0.1</p3>", {"p3 of a frame"});
  expect("</k3>", "</k3><corrections/>", {"corrections"});
  expect("<f>3219.5</f>", "<fx>3219</fx><fy>3219</fy>", {"fx", "1.2"});
  expect("<f>3219.5</f>", "", {"'f' is missing"});
  expect("3219.5", "-3219.5", {"focal length"});
  expect("3219.5", "", {"f: expected a finite number"});
  expect("<width>4096", "<width>4096.5", {"width"});
  expect("</k3>", "</k3><k3>0</k3>", {"line 13", "duplicate element 'k3'"});
  expect("</k3>", "", {"line", "not XML"});
  EXPECT_EQ(ParseMetashape(TextWith(kMetashape, "</k3>", "</k3><k4>0</k4>"))
                .cameras[0]
                .lens.values,
            ParseMetashape(kMetashape).cameras[0].lens.values);
}

}  // namespace
}  // namespace raygrid
