#include "dataset/camera_file.h"

#include <fmt/format.h>

#include "camera/central_radial.h"
#include "camera/model_registry.h"
#include "camera/splined_stereographic.h"
#include "camera/thin_prism_fisheye.h"
#include "camera/view_camera.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "example_camera_file.h"
#include "simulation/simulated_camera.h"
#include "support.h"

namespace raygrid {
namespace {

CameraFile NonCentralFile() {
  CameraFile file;
  file.camera = std::make_shared<NonCentralGeneric>(
      FitNonCentralGeneric(*MakeSimulatedCamera("glass", {640, 480}),
                           {1.0 / 3, 2, 630.1, 470}, 7, 6));
  return file;
}

CameraFile OpenCvFile() {
  CameraFile file;
  file.camera = std::make_shared<OpenCvModel>(ExampleLens());
  return file;
}

CameraFile ViewFile() {
  CameraFile file;
  file.camera = std::make_shared<ViewCamera>(
      ViewProjection::kCylindrical, ImageSize{800, 400}, WholeImage({800, 400}),
      Eigen::Vector4d(254.5, 255, 399.5, 199.5));
  file.camera_from_view =
      Pose{Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5), {0, 0, 0}};
  return file;
}

CameraFile FisheyeFile() {
  CameraFile file;
  file.camera = std::make_shared<ThinPrismFisheye>(
      ImageSize{640, 480}, Area{1, 2, 630, 470},
      ThinPrismFisheye::ParameterArray{200, 201, 322, 236, 0.01, 0.02, -0.003,
                                       1e-4, 1e-3, -8e-4, 2e-5, 3e-4});
  return file;
}

CameraFile SplinedFile() {
  CameraFile file;
  Eigen::VectorXd parameters(2 * 5 * 4 + 4);
  for (int k = 0; k < 40; ++k) parameters[k] = 0.01 / (k + 3);
  parameters.tail<4>() << 200, 201, 322, 236;
  file.camera = std::make_shared<SplinedStereographic>(
      ImageSize{640, 480}, Area{1, 2, 630, 470},
      SplinedStereographic::Grid{5, 4, 170}, parameters);
  return file;
}

CameraFile RadialFile() {
  CameraFile file;
  file.camera = std::make_shared<CentralRadial>(
      ImageSize{640, 480}, Area{1, 2, 630, 470}, 1.7,
      std::vector<double>{0.01, 0.02, 1.0 / 30, 0.04},
      CentralRadial::PlanarParameters{200, 201, 322, 236, 1e-3, -8e-4, 2e-5,
                                      3e-4});
  return file;
}

CameraFile ReadCameraText(const std::string& text) {
  const TemporaryFolder folder;
  WriteFile(folder / "camera.yaml", text);
  return ReadCameraFile(folder / "camera.yaml");
}

void ExpectCameraRefused(const std::string& text) {
  ExpectError(ExitCode::kInvalidInput, {"camera.yaml"},
              [&] { ReadCameraText(text); });
}

// The text with one part of it replaced.
std::string Replaced(std::string text, const std::string& from,
                     const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

TEST(CameraFile, RoundTripKeepsTheCamera) {
  for (const CameraFile& file : {GridFile(), NonCentralFile(), OpenCvFile(),
                                 FisheyeFile(), RadialFile(), SplinedFile()}) {
    const CameraFile read = ReadCameraText(FormatCameraFile(file));
    EXPECT_EQ(read.camera->Name(), file.camera->Name());
    EXPECT_EQ(read.camera->image_size(), file.camera->image_size());
    EXPECT_EQ(read.camera->area().x0, file.camera->area().x0);
    EXPECT_EQ(read.camera->area().y0, file.camera->area().y0);
    EXPECT_EQ(read.camera->area().x1, file.camera->area().x1);
    EXPECT_EQ(read.camera->area().y1, file.camera->area().y1);
    const Eigen::VectorXd written = file.camera->Parameters();
    ASSERT_EQ(read.camera->NumParameters(), written.size());
    EXPECT_LT(((read.camera->Parameters() - written).array() /
               written.array().abs().max(1))
                  .abs()
                  .maxCoeff(),
              1e-11);
  }
}

// Every model of named parameters comes back to the bit, if all digits are
// asked for.
TEST(CameraFile, HoldsEveryLensModelExactly) {
  for (const ModelInfo& model : GetModelRegistry()) {
    if (!model.make) continue;
    Eigen::VectorXd parameters = model.starts(700.0 / 3, 319, 241).front();
    for (Eigen::Index k = 0; k < parameters.size(); ++k)
      parameters[k] += 1e-3 / (3.0 + static_cast<double>(k));
    CameraFile file;
    file.camera = model.make({640, 480}, WholeImage({640, 480}), parameters);
    const CameraFile read =
        ReadCameraText(FormatCameraFile(file, Digits::kAll));
    EXPECT_EQ(read.camera->Name(), model.name);
    EXPECT_EQ(read.camera->Parameters(), parameters) << model.name;
    EXPECT_LT((ReadCameraText(FormatCameraFile(file)).camera->Parameters() -
               parameters)
                  .cwiseAbs()
                  .maxCoeff(),
              1e-8);
  }
}

TEST(CameraFile, RoundTripKeepsWhatIsKnownOfTheCamera) {
  const CameraFile file = GridFile();
  const CameraFile read = ReadCameraText(FormatCameraFile(file));
  EXPECT_EQ(read.name, file.name);
  EXPECT_EQ(read.serial, file.serial);
  ASSERT_TRUE(read.training && read.held_out);
  EXPECT_DOUBLE_EQ(read.training->rms_px, 0.12);
  EXPECT_DOUBLE_EQ(read.held_out->max_px, 1.9);
  EXPECT_EQ(read.held_out->count, 2900);
  EXPECT_FALSE(ReadCameraText(FormatCameraFile(OpenCvFile())).training);
}

TEST(CameraFile, FormatOfWhatWasReadIsTheSame) {
  for (const CameraFile& file : {GridFile(), NonCentralFile(), OpenCvFile(),
                                 FisheyeFile(), RadialFile(), SplinedFile()}) {
    const std::string text = FormatCameraFile(file);
    EXPECT_EQ(FormatCameraFile(ReadCameraText(text)), text);
  }
}

TEST(CameraFile, NumbersThatAreNotFiniteAreRefused) {
  const std::string generic = FormatCameraFile(GridFile());
  const size_t point = generic.find("- [") + 3;
  const size_t length = generic.find(',', point) - point;
  for (const char* bad : {".nan", ".inf", "-.inf", "word", "''"}) {
    ExpectCameraRefused(std::string(generic).replace(point, length, bad));
    ExpectCameraRefused(Replaced(FormatCameraFile(OpenCvFile()), "fx: 510",
                                 "fx: " + std::string(bad)));
    ExpectCameraRefused(Replaced(generic, "630.1", bad));
  }
}

TEST(CameraFile, SplinesThatAreNoneAreRefused) {
  const std::string radial = FormatCameraFile(RadialFile());
  for (const char* bad : {"-1", "0", "3.2", ".nan", "word"})
    ExpectCameraRefused(Replaced(radial, "max_angle_rad: 1.7",
                                 std::string("max_angle_rad: ") + bad));
  ExpectCameraRefused(Replaced(radial, "0.02", ".nan"));
  ExpectCameraRefused(Replaced(radial, "[0.01, 0.02, ", "["));
  ExpectCameraRefused(Replaced(radial, "sx1", "sx2"));
  const std::string splined = FormatCameraFile(SplinedFile());
  for (const auto& [from, to] :
       std::vector<std::pair<std::string, std::string>>{
           {"columns: 5", "columns: 3"},
           {"columns: 5", "columns: 6"},
           {"rows: 4", "rows: 2000"},
           {"fov_x_deg: 170", "fov_x_deg: 360"},
           {"fov_x_deg: 170", "fov_x_deg: 1.5"},
           {"fx: 200", "fx: 0"},
           {"[0.00", "[.nan, 0.00"}})
    ExpectCameraRefused(Replaced(splined, from, to));
}

TEST(CameraFile, SizesThatNoCameraHasAreRefused) {
  const std::string generic = FormatCameraFile(GridFile());
  const size_t size = generic.find("image_size: [") + 13;
  const size_t length = generic.find(']', size) - size;
  for (const char* bad : {"1000000, 1000", "1000, 65536", "0, 480", "640, -1",
                          "4294967936, 480", "640"})
    ExpectCameraRefused(std::string(generic).replace(size, length, bad));
}

TEST(CameraFile, WrongCountsAreRefused) {
  const std::string generic = FormatCameraFile(GridFile());
  ExpectCameraRefused(Replaced(generic, "columns: 7", "columns: 8"));
  ExpectCameraRefused(Replaced(generic, "rows: 6", "rows: 5"));
  ExpectCameraRefused(Replaced(generic, "columns: 7", "columns: 3"));
  ExpectCameraRefused(Replaced(generic, "columns: 7", "columns: 1000000"));
  const size_t point = generic.find("- [");
  const size_t end = generic.find('\n', point);
  ExpectCameraRefused(std::string(generic).erase(point, end - point));
  ExpectCameraRefused(
      std::string(generic).replace(point, end - point, "- [0.5]"));
  ExpectCameraRefused(
      std::string(generic).replace(point, end - point, "- [0.5, 1, 2]"));
  ExpectCameraRefused(
      Replaced(generic, "central-generic", "noncentral-generic"));
  ExpectCameraRefused(Replaced(FormatCameraFile(NonCentralFile()),
                               "noncentral-generic", "central-generic"));
  ExpectCameraRefused(Replaced(generic, "[640, 480]", "[640]"));
  ExpectCameraRefused(Replaced(generic, "[640, 480]", "[640, -480]"));
}

TEST(CameraFile, RowTimeIsReadAsItIsWritten) {
  CameraFile file = OpenCvFile();
  EXPECT_FALSE(
      ParseCameraFile("camera.yaml", FormatCameraFile(file)).line_delay);
  file.line_delay = {-20.125e-6, 0.03125e-6};
  std::string text = FormatCameraFile(file);
  auto read = ParseCameraFile("camera.yaml", text).line_delay;
  ASSERT_TRUE(read);
  EXPECT_NEAR(read->seconds, -20.125e-6, 1e-15);
  EXPECT_NEAR(read->stddev_s, 0.03125e-6, 1e-15);
  ExpectCameraRefused(Replaced(text, "row_time_us: -20", "row_time_us: -2000"));
  ExpectCameraRefused(Replaced(text, "row_time_us: -", "row_time_us: fast"));
  ExpectCameraRefused(Replaced(text, "deviation_us: 0", "deviation_us: -1"));
  ExpectCameraRefused(Replaced(text, "row_time_us: -", "row_tim_us: -"));
  file.line_delay->stddev_s = 0;
  text = FormatCameraFile(file);
  read = ParseCameraFile("camera.yaml", text).line_delay;
  ASSERT_TRUE(read);
  EXPECT_EQ(read->stddev_s, 0);
}

TEST(CameraFile, AreasOutsideTheImageAreRefused) {
  const std::string generic = FormatCameraFile(GridFile());
  ExpectCameraRefused(Replaced(generic, "[640, 480]", "[600, 480]"));
  const std::string lens = FormatCameraFile(OpenCvFile());
  ExpectCameraRefused(Replaced(lens, "[0, 0, 639, 479]", "[-1, 0, 639, 479]"));
  ExpectCameraRefused(Replaced(lens, "[0, 0, 639, 479]", "[100, 0, 50, 479]"));
  ExpectCameraRefused(Replaced(lens, "[0, 0, 639, 479]", "[0, 0, 639]"));
}

Capture ExampleCapture() {
  Capture capture;
  capture.lens_position = 2.1;
  capture.lens_tolerance = 1.0 / 3;
  capture.crop = {8, -4, 3280, 2464};
  capture.zoom = 1.25;
  capture.orientation = 6;
  capture.sensor_temperature_c = 41.25;
  capture.exposure_us = 8333;
  capture.analogue_gain = 1.5;
  return capture;
}

TEST(CameraFile, HoldsHowTheCameraStood) {
  CameraFile file = OpenCvFile();
  EXPECT_FALSE(ReadCameraText(FormatCameraFile(file)).capture);
  file.capture = ExampleCapture();
  const std::string text = FormatCameraFile(file);
  const auto read = ReadCameraText(text).capture;
  ASSERT_TRUE(read);
  EXPECT_EQ(read->lens_position, 2.1);
  EXPECT_EQ(read->lens_tolerance, 1.0 / 3);
  EXPECT_EQ(read->crop, file.capture->crop);
  EXPECT_EQ(read->zoom, 1.25);
  EXPECT_EQ(read->orientation, 6);
  EXPECT_EQ(read->sensor_temperature_c, 41.25);
  EXPECT_EQ(read->exposure_us, 8333);
  EXPECT_EQ(read->analogue_gain, 1.5);
  EXPECT_EQ(FormatCameraFile(ReadCameraText(text)), text);
  for (const auto& [word, bad] :
       {std::pair("lens_position: 2.1", "lens_position: 1025"),
        std::pair("lens_position: 2.1", "lens_position: .nan"),
        std::pair("lens_position: 2.1", "lens_positoin: 2.1"),
        std::pair("zoom: 1.25", "zoom: 0.5"),
        std::pair("[8, -4, 3280, 2464]", "[8, -4, 3280, 0]"),
        std::pair("[8, -4, 3280, 2464]", "[8, -4, 40961, 2464]"),
        std::pair("[8, -4, 3280, 2464]", "[8, -4, 3280]"),
        std::pair("orientation: 6", "orientation: 0"),
        std::pair("41.25", "1025"), std::pair("8333", "0"),
        std::pair("analogue_gain: 1.5", "analogue_gain: 0")})
    ExpectCameraRefused(Replaced(text, word, bad));
}

TEST(CameraFile, HoldsOneThingOfHowTheCameraStood) {
  CameraFile file = OpenCvFile();
  file.capture.emplace().orientation = 8;
  const auto read = ReadCameraText(FormatCameraFile(file)).capture;
  ASSERT_TRUE(read);
  EXPECT_EQ(read->orientation, 8);
  EXPECT_FALSE(read->lens_position || read->crop || read->zoom);
}

TEST(CameraFile, HoldsTheImageCircle) {
  CameraFile file = OpenCvFile();
  EXPECT_FALSE(ReadCameraText(FormatCameraFile(file)).camera->image_circle());
  const std::unique_ptr<CameraModel> camera = file.camera->Clone();
  camera->SetImageCircle(ImageCircle{{320.25, -7.5}, {280.125, 280.125}});
  file.camera = std::shared_ptr<const CameraModel>(camera->Clone());
  const std::string text = FormatCameraFile(file);
  const auto circle = ReadCameraText(text).camera->image_circle();
  ASSERT_TRUE(circle);
  EXPECT_EQ(circle->center, Eigen::Vector2d(320.25, -7.5));
  EXPECT_EQ(circle->radii_px, Eigen::Vector2d(280.125, 280.125));
  const std::string list = "[320.250, -7.500, 280.125]";
  for (const char* bad : {"[320, 240, 0]", "[320, 240, -1]", "[320, 240]",
                          "[320, .nan, 100]", "320"})
    ExpectCameraRefused(Replaced(text, list, bad));
}

TEST(CameraFile, OtherDocumentsAreRefused) {
  const std::string generic = FormatCameraFile(GridFile());
  ExpectCameraRefused("");
  ExpectCameraRefused("text");
  ExpectCameraRefused("[");
  ExpectCameraRefused("raygrid_camera: 1\n");
  ExpectCameraRefused("raygrid_camera: 1\nmodel: opencv\n");
  ExpectCameraRefused(
      Replaced(generic, "raygrid_camera: 1", "raygrid_camera: 2"));
  ExpectCameraRefused(Replaced(generic, "central-generic", "pinhole"));
  ExpectCameraRefused(Replaced(generic, "stereographic", "mercator"));
  ExpectCameraRefused(Replaced(FormatCameraFile(OpenCvFile()), "k6:", "k7:"));
  ExpectError(ExitCode::kInvalidInput, {"nowhere.yaml"},
              [] { ReadCameraFile("nowhere.yaml"); });
}

TEST(CameraFile, EveryTruncationIsReadOrRefusedButNoCrash) {
  const std::string text = FormatCameraFile(GridFile());
  for (size_t size = 0; size < text.size(); size += 37) {
    try {
      ReadCameraText(text.substr(0, size));
      ADD_FAILURE() << "read with " << size << " bytes";
    } catch (const InputError&) {
      if (size > text.find("quality")) break;
    }
    if (size > text.find("quality")) break;
  }
}

TEST(CameraFile, KeepsUncertaintyAndMask) {
  CameraFile file = GridFile();
  file.uncertainty = ExampleUncertainty();
  const std::string text = FormatCameraFile(file);
  const CameraFile read = ReadCameraText(text);
  ASSERT_TRUE(read.uncertainty);
  const UncertaintyLattice& lattice = read.uncertainty->lattice;
  EXPECT_EQ(lattice.columns, 3);
  EXPECT_EQ(lattice.rows, 2);
  EXPECT_EQ(lattice.stddev_px[5], 0.25);
  EXPECT_TRUE(std::isnan(lattice.stddev_px[4]));
  EXPECT_EQ(read.uncertainty->mask.knot_spacing_px, 16);
  EXPECT_EQ(read.uncertainty->mask.is_valid, file.uncertainty->mask.is_valid);
  EXPECT_EQ(read.uncertainty->max_stddev_px, 0.025);
  EXPECT_EQ(read.uncertainty->modes.columns, 2);
  EXPECT_EQ(read.uncertainty->modes.residual_px, 0.004);
  EXPECT_EQ(read.uncertainty->modes.displacements_px,
            file.uncertainty->modes.displacements_px);
  EXPECT_EQ(read.uncertainty->modes.excess_errors.scale, 0.001);
  EXPECT_EQ(read.uncertainty->modes.excess_errors.shift_px, 0.375);
  EXPECT_EQ(read.uncertainty->modes.excess_errors.tilt_rad, 0.0005);
  EXPECT_EQ(read.uncertainty->modes.excess_errors.local_px, 0.03);
  EXPECT_EQ(FormatCameraFile(read), text);
}

TEST(CameraFile, KeepsAMaskWithoutUncertainty) {
  CameraFile file = GridFile();
  file.uncertainty = CameraUncertainty::FromMask(ExampleUncertainty().mask);
  const std::string text = FormatCameraFile(file);
  EXPECT_EQ(text.find("uncertainty"), std::string::npos);
  const CameraFile read = ReadCameraText(text);
  ASSERT_TRUE(read.uncertainty);
  EXPECT_FALSE(read.uncertainty->HasStdDevs());
  EXPECT_EQ(read.uncertainty->mask.is_valid, file.uncertainty->mask.is_valid);
  EXPECT_EQ(FormatCameraFile(read), text);
  // A file that was cut has lost its uncertainty.
  std::string cut = text;
  cut.replace(cut.find("  cell_px"), 0, "  max_deviation_px: 0.025\n");
  EXPECT_THROW(ReadCameraText(cut), InputError);
}

TEST(CameraFile, RefusesAMalformedMaskOrLattice) {
  CameraFile file = GridFile();
  file.uncertainty = ExampleUncertainty();
  const std::string text = FormatCameraFile(file);
  for (const auto& [from, to] :
       std::vector<std::pair<std::string, std::string>>{
           {"cell_px: 16", "cell_px: 15"},
           {"cell_px: 16", "cell_px: 32"},
           {"#..", "#.x"},
           {"#..", "#."},
           {"0.250000", "-1"},
           {"0.250000", "0.25, 0.3"},
           {"shift_px: 0.375000", "shift_px: -1"},
           {"rest_px: 0.004", "rest_px: -1"},
           {"-0.50000", ".nan"},
           {"-0.50000", "-0.5, 1"},
           {"  columns: 3", "  columns: 1"}}) {
    std::string broken = text;
    const size_t place = broken.rfind(from);
    ASSERT_NE(place, std::string::npos) << from;
    broken.replace(place, from.size(), to);
    EXPECT_THROW(ReadCameraText(broken), InputError) << to;
  }
}

CameraFile FileOfAFleet() {
  CameraFile file = GridFile();
  file.spread = PopulationCovariance{4, 5, {}};
  for (int k = 0; k < 2; ++k) {
    auto& field = file.spread->displacements_px.emplace_back();
    for (int i = 0; i < 20; ++i) field.emplace_back(0.25 * i, -0.125 * k * i);
  }
  return file;
}

TEST(CameraFile, KeepsTheSpreadOfAFleet) {
  const CameraFile file = FileOfAFleet();
  const std::string text = FormatCameraFile(file);
  const CameraFile read = ReadCameraText(text);
  ASSERT_TRUE(read.spread);
  EXPECT_EQ(read.spread->columns, 4);
  EXPECT_EQ(read.spread->rows, 5);
  EXPECT_EQ(read.spread->displacements_px, file.spread->displacements_px);
  EXPECT_EQ(FormatCameraFile(read), text);
  EXPECT_FALSE(ReadCameraText(FormatCameraFile(GridFile())).spread);
}

TEST(CameraFile, RefusesAMalformedSpread) {
  const std::string text = FormatCameraFile(FileOfAFleet());
  const size_t spread = text.find("spread:");
  const std::string before = text.substr(0, spread), own = text.substr(spread);
  const auto refused = [&](const std::string& from, const std::string& to,
                           const std::string& told) {
    ExpectError(ExitCode::kInvalidInput,
                {"spread: " + told, "use the file as written by raygrid batch"},
                [&] { ReadCameraText(before + Replaced(own, from, to)); });
  };
  const std::string columns = "columns must be an integer from 4 to 65";
  for (const char* number : {"3", "66", "many", "[4]", "4.5", "99999999999"})
    refused("columns: 4", std::string("columns: ") + number, columns);
  refused("columns: 4", "column: 4", columns);
  refused("rows: 5", "rows: many", "rows must be");
  refused("columns: 4", "columns: 6",
          "one of displacements_px: expected a list");
  for (const char* number : {".nan", ".inf", "far", "~", "[1]"})
    refused("0.25000", number, "displacements_px in line ");
  refused("displacements_px", "displacements", "displacements_px must be 1 to");
  for (const char* value : {"3", "[4, 5]", "~"})
    refused("spread:", fmt::format("spread: {}\nspare:", value),
            "expected columns, rows and displacements_px");
  CameraFile none = FileOfAFleet();
  none.spread->displacements_px.clear();
  ExpectCameraRefused(FormatCameraFile(none));
}

TEST(ErrorModes, AreBilinearBetweenTheirPixels) {
  const ErrorModes modes = ExampleUncertainty().modes;
  const Area area = {10, 20, 110, 70};
  EXPECT_LT((modes.At(0, area, {10, 20}) - Eigen::Vector2d(0.01, 0.02)).norm(),
            1e-12);
  EXPECT_LT(
      (modes.At(0, area, {60, 45}) - Eigen::Vector2d(-0.115, 0.03625)).norm(),
      1e-12);
}

TEST(UncertaintyLattice, IsBilinearBetweenItsPixels) {
  UncertaintyLattice lattice = {3, 2, {0.01, 0.02, 0.03, 0.04, 0.08, 0.25}};
  const Area area = {10, 20, 110, 70};
  EXPECT_NEAR(lattice.At(area, {10, 20}), 0.01, 1e-12);
  EXPECT_NEAR(lattice.At(area, {110, 70}), 0.25, 1e-12);
  EXPECT_NEAR(lattice.At(area, {35, 20}), 0.015, 1e-12);
  EXPECT_NEAR(lattice.At(area, {35, 45}), 0.0375, 1e-12);
  lattice.stddev_px[3] = NAN;
  EXPECT_TRUE(std::isnan(lattice.At(area, {30, 50})));
  EXPECT_NEAR(lattice.At(area, {35, 45}), 0.11 / 3, 1e-12);
  EXPECT_NEAR(lattice.MedianPx(), 0.03, 1e-12);
}

TEST(CameraFile, HoldsViewsAndHowTheyAreTurned) {
  const std::string text = FormatCameraFile(ViewFile());
  const CameraFile read = ParseCameraFile("view.camera.yaml", text);
  EXPECT_EQ(read.camera->Name(), "cylindrical");
  EXPECT_EQ(read.camera->Parameters(), ViewFile().camera->Parameters());
  ASSERT_TRUE(read.camera_from_view);
  EXPECT_LT(read.camera_from_view->rotation.angularDistance(
                ViewFile().camera_from_view->rotation),
            1e-9);
  EXPECT_EQ(FormatCameraFile(read), text);
  const size_t at = text.find("254.5");
  ExpectError(ExitCode::kInvalidInput, {"view.camera.yaml", "positive"}, [&] {
    ParseCameraFile("view.camera.yaml",
                    text.substr(0, at) + "0" + text.substr(at + 5));
  });
}

}  // namespace
}  // namespace raygrid
