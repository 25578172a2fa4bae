#include <raygrid_host/camera.h>

#include <atomic>
#include <cstdlib>
#include <map>
#include <new>

#include "camera/central_radial.h"
#include "camera/model_registry.h"
#include "camera/splined_stereographic.h"
#include "camera/view_camera.h"
#include "dataset/camera_file.h"
#include "dataset/files.h"
#include "dataset/rig_file.h"
#include "raygrid_host/rig.h"
#include "simulation/simulated_camera.h"
#include "support.h"

namespace {
std::atomic<int> num_allocations{0};
}  // namespace

// The library's allocations, too.
void* operator new(size_t size) {
  ++num_allocations;
  if (void* memory = std::malloc(size ? size : 1)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, size_t) noexcept { std::free(memory); }

namespace raygrid {
namespace {

using ModelPointer = std::shared_ptr<const CameraModel>;

ModelPointer Shared(const CameraModel& model) { return model.Clone(); }

std::string TextOf(const ModelPointer& model) {
  CameraFile file;
  file.camera = model;
  return FormatCameraFile(file, Digits::kAll);
}

// The model's camera, of which there is one for all tests.
CameraD Opened(const ModelPointer& model) {
  static std::map<ModelPointer, CameraD> cameras;
  const auto known = cameras.find(model);
  if (known != cameras.end()) return known->second;
  std::string error;
  auto camera = CameraD::Parse(TextOf(model), &error);
  if (!camera) throw std::runtime_error(error);
  return cameras.emplace(model, *camera).first->second;
}

// A lens with some distortion.
ModelPointer ExampleLensOf(const ModelInfo& lens) {
  const ImageSize size = {640, 480};
  Eigen::VectorXd parameters = lens.starts(500, 322, 236).front();
  for (size_t k = 0; k < lens.parameters.size(); ++k) {
    const std::string& name = lens.parameters[k];
    if (name == "k1" || name == "k4") parameters[k] = -0.08;
    if (name == "k2") parameters[k] = 0.02;
    if (name[0] == 'p' || name[0] == 's' || name[0] == 't')
      parameters[k] = 1e-3;
  }
  return lens.make(size, WholeImage(size), parameters);
}

CentralRadial ExampleSpline() {
  const ImageSize size = {640, 480};
  std::vector<double> spline;
  for (int k = 1; k <= 12; ++k) spline.push_back(-0.002 * k * k);
  return CentralRadial(size, WholeImage(size), 1.2, spline,
                       {400, 402, 321, 238, 1e-3, -1e-3, 5e-4, 0});
}

NonCentralGeneric ExampleLinesOf(const CentralGeneric& central) {
  NonCentralGeneric lines(central);
  Eigen::VectorXd parameters = lines.Parameters();
  TestRandom random(4);
  for (Eigen::Index k = 0; k < parameters.size(); ++k)
    if (k % NonCentralGeneric::kPerNode >= 2)
      parameters[k] = 0.01 + 0.001 * random.Normal();
  lines.SetParameters(parameters);
  return lines;
}

// All models of camera.yaml, and grids with folds.
const std::vector<ModelPointer>& Models() {
  static const std::vector<ModelPointer> models = [] {
    const CentralGeneric grid = FittedGrid(ExampleSimulatedCamera(), 40);
    std::vector<ModelPointer> all = {
        Shared(grid),
        Shared(ExampleFisheye()),
        Shared(FoldedFisheye(300, 1)),
        Shared(ExampleLinesOf(grid)),
        Shared(ExampleLinesOf(ExampleFisheye())),
        Shared(ExampleLinesOf(FoldedFisheye(380, 1))),
        Shared(ExampleLens()),
        Shared(ExampleSpline()),
        FitSplinedStereographic(grid, nullptr),
        Shared(ViewCamera(ViewProjection::kEquirectangular, {640, 480},
                          WholeImage({640, 480}), {100, 100, 319.5, 239.5}))};
    for (const ModelInfo& lens : GetModelRegistry())
      if (lens.make) all.push_back(ExampleLensOf(lens));
    // Files have 12 decimals of control points.
    for (ModelPointer& model : all)
      model = ParseCameraFile("camera.yaml", TextOf(model)).camera;
    return all;
  }();
  return models;
}

// Random pixels, of which some are outside the area.
std::vector<Eigen::Vector2d> PixelsAround(const Area& area, int count) {
  TestRandom random(5);
  std::vector<Eigen::Vector2d> pixels;
  for (int k = 0; k < count; ++k)
    pixels.push_back(random.PixelIn(
        {area.x0 - 20, area.y0 - 20, area.x1 + 20, area.y1 + 20}));
  return pixels;
}

// Points on lines of sight, and anywhere.
std::vector<Eigen::Vector3d> PointsAround(const CameraModel& model, int count) {
  TestRandom random(6);
  std::vector<Eigen::Vector3d> points;
  for (int k = 0; k < count; ++k) {
    const auto line = model.Line(random.PixelIn(model.area()));
    points.push_back(line && k % 3
                         ? PointAlong(*line, random.Uniform(0.3, 10))
                         : Eigen::Vector3d(2 * random.NormalVector<3>()));
  }
  return points;
}

TEST(HostCamera, ProjectsAsTheCalibratorDoes) {
  for (const ModelPointer& model : Models()) {
    SCOPED_TRACE(model->Name());
    const CameraD camera = Opened(model);
    int num_defined = 0;
    for (const Eigen::Vector3d& point : PointsAround(*model, 600)) {
      const auto expected = model->Project(point);
      Eigen::Vector2d pixel;
      ASSERT_EQ(camera.Project(point, &pixel), expected.has_value())
          << point.transpose();
      if (!expected) continue;
      ++num_defined;
      // The calibrator's search ends with steps of 1e-9 px.
      EXPECT_LT((pixel - *expected).norm(), 2e-9) << point.transpose();
    }
    EXPECT_GT(num_defined, 250);
  }
}

TEST(HostCamera, UnprojectsAsTheCalibratorDoes) {
  for (const ModelPointer& model : Models()) {
    SCOPED_TRACE(model->Name());
    const CameraD camera = Opened(model);
    int num_defined = 0;
    for (const Eigen::Vector2d& pixel : PixelsAround(model->area(), 500)) {
      const auto expected = model->Line(pixel);
      Eigen::Vector3d origin, bearing;
      ASSERT_EQ(camera.UnprojectLine(pixel, &origin, &bearing),
                expected.has_value())
          << pixel.transpose();
      if (!expected) continue;
      ++num_defined;
      // Images have less than 1000 pixels per radian.
      EXPECT_LT((bearing - expected->direction).norm(), 1e-12);
      EXPECT_LT((origin - expected->origin).norm(), 1e-14);
    }
    EXPECT_GT(num_defined, 250);
  }
}

TEST(HostCamera, RoundsToAThousandthOfAPixelInFloat) {
  for (const ModelPointer& model : Models()) {
    // Near folds, pixels vary without bound.
    if (model->DirectionGrid() &&
        ComputeUnfoldedSide(*model->DirectionGrid()).folds())
      continue;
    SCOPED_TRACE(model->Name());
    const CameraF camera = Opened(model).Cast<float>();
    int num_defined = 0;
    for (const Eigen::Vector2d& at : PixelsAround(model->area(), 300)) {
      const Eigen::Vector2f pixel = at.cast<float>();
      Eigen::Vector3f origin, bearing;
      if (!camera.UnprojectLine(pixel, &origin, &bearing)) continue;
      const Eigen::Vector3f point = origin + 2 * bearing;
      const Eigen::Vector2d start = pixel.cast<double>();
      const auto back = model->Project(point.cast<double>(), &start, 1);
      Eigen::Vector2f projection;
      if (!back || !camera.Project(point, &projection)) continue;
      ++num_defined;
      EXPECT_LT((*back - start).norm(), 1e-3) << at.transpose();
      EXPECT_LT((projection - pixel).norm(), 1e-3) << at.transpose();
    }
    EXPECT_GT(num_defined, 100);
  }
}

TEST(HostCamera, ArraysHaveTheResultsOfSinglePixelsAndPoints) {
  for (const ModelPointer& model : Models()) {
    SCOPED_TRACE(model->Name());
    const CameraD camera = Opened(model);
    const auto some = PixelsAround(model->area(), 50);
    CameraD::Pixels pixels(2, 50);
    for (int k = 0; k < 50; ++k) pixels.col(k) = some[k];
    CameraD::Points origins(3, 50), bearings(3, 50);
    int num_defined = 0;
    const int num_lines = camera.UnprojectAllLines(pixels, origins, bearings);
    for (int k = 0; k < 50; ++k) {
      Eigen::Vector3d origin, bearing;
      const bool is_defined = camera.UnprojectLine(some[k], &origin, &bearing);
      num_defined += is_defined;
      EXPECT_EQ(bearings.col(k).hasNaN(), !is_defined);
      if (!is_defined) continue;
      EXPECT_EQ(bearings.col(k), bearing);
      EXPECT_EQ(origins.col(k), origin);
    }
    EXPECT_EQ(num_lines, num_defined);
    EXPECT_EQ(camera.UnprojectAll(pixels, bearings), num_defined);

    const CameraD::Points points = 2 * bearings + origins;
    const int num_pixels = camera.ProjectAll(points, pixels);
    for (int k = 0; k < 50; ++k) {
      Eigen::Vector2d pixel;
      const bool is_defined = camera.Project(points.col(k), &pixel);
      num_defined -= is_defined;
      EXPECT_EQ(pixels.col(k).hasNaN(), !is_defined);
      if (is_defined) EXPECT_EQ(pixels.col(k), pixel);
    }
    EXPECT_EQ(num_pixels + num_defined, num_lines);
    // Rows of larger matrices; shorter outputs are not overrun.
    Eigen::Matrix4Xd few = Eigen::Matrix4Xd::Constant(4, 7, 7);
    camera.UnprojectAll(pixels, few.topLeftCorner(3, 5));
    camera.UnprojectAll(pixels, bearings);
    for (int k = 0; k < 5; ++k)
      EXPECT_TRUE(few.col(k).head<3>() == bearings.col(k) ||
                  bearings.col(k).hasNaN());
    EXPECT_EQ(few.bottomRows(1), (Eigen::MatrixXd::Constant(1, 7, 7)));
    EXPECT_EQ(few.rightCols(2), (Eigen::MatrixXd::Constant(4, 2, 7)));
  }
}

TEST(HostCamera, JacobiansAreDerivatives) {
  for (const ModelPointer& model : Models()) {
    SCOPED_TRACE(model->Name());
    const CameraD camera = Opened(model);
    const Eigen::Vector2d center = model->area().center();
    for (const Eigen::Vector2d& offset :
         {Eigen::Vector2d(3, 5), Eigen::Vector2d(-100, 80)}) {
      const Eigen::Vector2d pixel = center + offset;
      Eigen::Vector3d origin, bearing;
      Eigen::Matrix<double, 3, 2> origin_J, bearing_J, only_J;
      ASSERT_TRUE(camera.UnprojectLine(pixel, &origin, &bearing, &origin_J,
                                       &bearing_J));
      ASSERT_TRUE(camera.Unproject(pixel, &bearing, &only_J));
      EXPECT_EQ(only_J, bearing_J);
      const auto line_at = [&](const Eigen::VectorXd& at) -> Eigen::VectorXd {
        Eigen::Matrix<double, 3, 2> line;
        Eigen::Vector3d o, d;
        EXPECT_TRUE(camera.UnprojectLine(at, &o, &d));
        line << o, d;
        return Eigen::Map<Eigen::VectorXd>(line.data(), 6);
      };
      Eigen::Matrix<double, 6, 2> J;
      J << origin_J, bearing_J;
      EXPECT_LT((J - CentralDifference(line_at, pixel, 1e-3)).norm(), 1e-8);

      const Eigen::Vector3d point = origin + 2 * bearing;
      Eigen::Vector2d projection;
      Eigen::Matrix<double, 2, 3> J_point, with_intrinsics;
      IntrinsicsJacobian<double> J_intrinsics;
      ASSERT_TRUE(camera.Project(point, &projection, &J_point));
      ASSERT_TRUE(
          camera.Project(point, &projection, &with_intrinsics, &J_intrinsics));
      EXPECT_LT((with_intrinsics - J_point).norm(), 1e-6);
      const auto project = [&](const Eigen::VectorXd& at) -> Eigen::VectorXd {
        Eigen::Vector2d result;
        EXPECT_TRUE(camera.Project(at, &result));
        return result;
      };
      EXPECT_LT(
          RelativeDifference(J_point, CentralDifference(project, point, 1e-5)),
          1e-6);
      // One of the columns, since each takes another camera.
      for (const int k : {0, J_intrinsics.num_columns - 1}) {
        const int parameter = J_intrinsics.parameter[k];
        const auto project_with = [&](double change) {
          CameraD changed = camera;
          Eigen::VectorXd parameters = camera.Parameters();
          parameters[parameter] += change;
          EXPECT_TRUE(changed.SetParameters(parameters));
          Eigen::Vector2d result;
          EXPECT_TRUE(changed.Project(point, &result));
          return result;
        };
        const Eigen::Vector2d derivative =
            (project_with(1e-5) - project_with(-1e-5)) / 2e-5;
        EXPECT_LT((J_intrinsics.values.col(k) - derivative).norm(),
                  1e-4 + 1e-4 * derivative.norm());
      }
    }
  }
}

TEST(HostCamera, DenseJacobianHasAllColumns) {
  const ModelPointer model = Shared(ExampleLens());
  const CameraD camera = Opened(model);
  IntrinsicsJacobian<double> J;
  Eigen::Vector2d pixel;
  ASSERT_TRUE(camera.Project({0.1, 0.2, 1}, &pixel, nullptr, &J));
  EXPECT_EQ(J.num_columns, camera.NumParameters());
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(2, camera.NumParameters());
  J.AddTo(&dense);
  LinearizedProjection expected;
  ASSERT_TRUE(model->Linearize({0.1, 0.2, 1}, nullptr, 0, &expected));
  EXPECT_EQ(dense, DenseByParameter(expected, camera.NumParameters()));
}

TEST(HostCamera, NothingIsDefinedForNumbersThatAreNotFinite) {
  for (const ModelPointer& model : Models()) {
    SCOPED_TRACE(model->Name());
    const CameraD camera = Opened(model);
    Eigen::Vector3d bearing(7, 7, 7);
    Eigen::Vector2d pixel(7, 7);
    for (const double bad :
         {double(NAN), double(INFINITY), double(-INFINITY)}) {
      EXPECT_FALSE(camera.Unproject({bad, 100}, &bearing));
      EXPECT_FALSE(camera.Project({0.1, bad, 1}, &pixel));
      EXPECT_FALSE(camera.IsIlluminated({100, bad}));
      EXPECT_FALSE(camera.IsInValidRegion({100, bad}));
    }
    EXPECT_FALSE(camera.Unproject({1e300, 100}, &bearing));
    EXPECT_FALSE(camera.Project({NAN, NAN, NAN}, &pixel));
    EXPECT_EQ(bearing, Eigen::Vector3d(7, 7, 7));
    EXPECT_EQ(pixel, Eigen::Vector2d(7, 7));
  }
}

TEST(HostCamera, DoesNotAllocate) {
  for (const ModelPointer& model : Models()) {
    const CameraD camera = Opened(model);
    const auto pixels = PixelsAround(model->area(), 100);
    const auto points = PointsAround(*model, 100);
    const int before = num_allocations;
    for (int k = 0; k < 100; ++k) {
      Eigen::Vector3d origin, bearing;
      Eigen::Vector2d pixel;
      Eigen::Matrix<double, 2, 3> J_point;
      Eigen::Matrix<double, 3, 2> origin_J, J_pixel;
      IntrinsicsJacobian<double> J_intrinsics;
      camera.UnprojectLine(pixels[k], &origin, &bearing, &origin_J, &J_pixel);
      camera.Unproject(pixels[k], &bearing);
      camera.Project(points[k], &pixel);
      camera.Project(points[k], &pixel, &J_point, &J_intrinsics);
    }
    EXPECT_EQ(num_allocations, before) << model->Name();
  }
}

TEST(HostCamera, IsRestoredFromItsText) {
  for (const ModelPointer& model : Models()) {
    const CameraD camera = Opened(model);
    EXPECT_EQ(camera.Format(), TextOf(model)) << model->Name();
    EXPECT_EQ(camera.Parameters(), model->Parameters()) << model->Name();
    EXPECT_EQ(camera.Cast<float>().Cast<double>().Format(), camera.Format());
  }
}

TEST(HostCamera, ChangedParametersAreThoseOfTheCameraAlone) {
  for (const ModelPointer& model : Models()) {
    SCOPED_TRACE(model->Name());
    const CameraD camera = Opened(model);
    CameraD changed = camera;
    // A grid then extends beyond the directions of the original camera.
    const double factor = model->DirectionGrid() ? 1.05 : 1.003;
    const Eigen::VectorXd parameters = factor * camera.Parameters();
    ASSERT_TRUE(changed.SetParameters(parameters));
    EXPECT_EQ(camera.Parameters(), model->Parameters());
    const auto expected = model->Clone();
    expected->SetParameters(parameters);
    TestRandom random(8);
    for (int k = 0; k < 100; ++k) {
      const Eigen::Vector2d pixel = random.PixelIn(model->area());
      const auto line = expected->Line(pixel);
      Eigen::Vector3d bearing;
      ASSERT_EQ(changed.Unproject(pixel, &bearing), line.has_value());
      if (!line) continue;
      EXPECT_LT((bearing - line->direction).norm(), 1e-12);
      Eigen::Vector2d back;
      const Eigen::Vector3d point = PointAlong(*line, 2);
      const auto projection = expected->Project(point);
      ASSERT_EQ(changed.Project(point, &back), projection.has_value());
      if (projection) EXPECT_LT((back - *projection).norm(), 2e-9);
    }
    EXPECT_FALSE(changed.SetParameters(parameters.head(3)));
    EXPECT_FALSE(changed.SetParameters(NAN * parameters));
    EXPECT_EQ(changed.Parameters(), parameters);
  }
}

TEST(HostCamera, SaysWhatIsWrongWithAFile) {
  const TemporaryFolder folder;
  std::string error;
  EXPECT_FALSE(CameraD::Load(folder / "none.yaml", &error));
  EXPECT_NE(error.find("none.yaml"), std::string::npos) << error;
  EXPECT_FALSE(CameraF::Parse("raygrid_camera: 1\nmodel: opencv\n", &error));
  EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  EXPECT_FALSE(CameraF::Parse("raygrid_camera: 1\n"));
}

TEST(HostCamera, HasUncertaintyAndValidRegionOfItsFile) {
  CameraFile file;
  const ModelPointer model = Shared(ExampleLens());
  const auto circled = model->Clone();
  circled->SetImageCircle(ImageCircle{{320, 240}, {300, 300}});
  file.camera = std::shared_ptr<const CameraModel>(circled->Clone());
  CameraUncertainty uncertainty;
  uncertainty.lattice = {3, 2, {0.1, 0.3, NAN, 0.1, 0.3, NAN}};
  uncertainty.mask = ValidityMask::Over(model->image_size());
  uncertainty.mask.is_valid[uncertainty.mask.CellIndex({320, 240})] = true;
  uncertainty.max_stddev_px = 0.3;
  file.uncertainty = uncertainty;
  const auto camera = CameraD::Parse(FormatCameraFile(file, Digits::kAll));
  ASSERT_TRUE(camera);
  double stddev_px = 7;
  EXPECT_TRUE(camera->Uncertainty({159.75, 0}, &stddev_px));
  EXPECT_NEAR(stddev_px, 0.2, 1e-6);
  EXPECT_FALSE(camera->Uncertainty({639, 479}, &stddev_px));
  EXPECT_FALSE(camera->Uncertainty({-1, 0}, &stddev_px));
  EXPECT_TRUE(camera->IsInValidRegion({320, 240}));
  EXPECT_FALSE(camera->IsInValidRegion({120, 240}));
  EXPECT_TRUE(camera->IsIlluminated({120, 240}));
  EXPECT_FALSE(camera->IsIlluminated({1, 1}));
  EXPECT_EQ(camera->Bounds().max(), Eigen::Vector2d(639, 479));
  EXPECT_FALSE(Opened(model).Uncertainty({320, 240}, &stddev_px));
  EXPECT_TRUE(Opened(model).IsInValidRegion({120, 240}));
}

TEST(HostRig, HasTheCamerasOfItsFile) {
  const TemporaryFolder folder;
  WriteFile(folder / "left.yaml", TextOf(Models()[0]));
  WriteFile(folder / "right.yaml", TextOf(Shared(ExampleLens())));
  const Pose pose = {RotationFromVector({0.1, 0.2, 0.3}), {0.5, -0.1, 0.2}};
  WriteFile(folder / "rig.yaml",
            FormatRigFile({{"left", "left.yaml", Pose()},
                           {"right", "right.yaml", pose}}));
  std::string error;
  const auto rig = LoadRig<double>(folder / "rig.yaml", &error);
  ASSERT_EQ(rig.size(), 2U) << error;
  EXPECT_EQ(rig[1].name, "right");
  EXPECT_EQ(rig[1].camera.Model(), "opencv");
  const Eigen::Vector3d point(1, 2, 3);
  EXPECT_LT((rig[1].camera_from_rig * point - pose * point).norm(), 1e-8);

  WriteFile(folder / "left.yaml", "raygrid_camera: 1\n");
  EXPECT_TRUE(LoadRig<float>(folder / "rig.yaml", &error).empty());
  EXPECT_NE(error.find("left.yaml"), std::string::npos) << error;
}

}  // namespace
}  // namespace raygrid
