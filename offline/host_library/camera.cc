#include <raygrid_host/camera.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "camera/parametric_model.h"
#include "host_library/camera_data.h"
#include "host_library/grid_evaluator.h"
#include "host_library/parametric_evaluator.h"

namespace raygrid {

namespace host {

template <typename Scalar>
std::shared_ptr<const Evaluator<Scalar>> MakeEvaluator(
    std::shared_ptr<const CameraModel> model) {
  return model->DirectionGrid()
             ? MakeGridEvaluator<Scalar>(std::move(model))
             : MakeParametricEvaluator<Scalar>(std::move(model));
}

}  // namespace host

namespace {

// Copies the columns of nodes with a weight, and those of global parameters.
template <typename Scalar>
void CopyColumns(const LinearizedProjection& projection,
                 IntrinsicsJacobian<Scalar>* J) {
  int count = 0;
  const auto add = [&](int parameter, const Eigen::Vector2d& column) {
    J->parameter[count] = parameter;
    J->values.col(count) = column.cast<Scalar>();
    ++count;
  };
  for (int node = 0; node < projection.num_nodes; ++node) {
    const double weight = projection.node_weight[node];
    if (weight == 0) continue;
    for (int k = 0; k < projection.num_per_node; ++k)
      add(projection.node_parameter[node] + k,
          weight * projection.J_node.col(k));
  }
  for (int k = 0; k < projection.num_global; ++k)
    add(projection.first_global + k, projection.J_global.col(k));
  J->num_columns = count;
}

std::optional<CameraFile> ReadCamera(const std::string& path,
                                     const std::string* text,
                                     std::string* error) {
  try {
    return text ? ParseCameraFile(path, *text) : ReadCameraFile(path);
  } catch (const std::exception& exception) {
    if (error) *error = exception.what();
    return std::nullopt;
  }
}

}  // namespace

const char* HostLibraryVersion() { return RAYGRID_VERSION; }

template <typename Scalar>
Camera<Scalar>::Camera(std::shared_ptr<const Data> data)
    : data_(std::move(data)) {}

template <typename Scalar>
std::optional<Camera<Scalar>> Camera<Scalar>::Load(const std::string& path,
                                                   std::string* error) {
  auto file = ReadCamera(path, nullptr, error);
  if (!file) return std::nullopt;
  auto shared = std::make_shared<const CameraFile>(*std::move(file));
  return Camera(Data::Make(shared, shared->camera));
}

template <typename Scalar>
std::optional<Camera<Scalar>> Camera<Scalar>::Parse(const std::string& text,
                                                    std::string* error) {
  auto file = ReadCamera("camera.yaml", &text, error);
  if (!file) return std::nullopt;
  auto shared = std::make_shared<const CameraFile>(*std::move(file));
  return Camera(Data::Make(shared, shared->camera));
}

template <typename Scalar>
std::string Camera<Scalar>::Format() const {
  CameraFile file = *data_->file;
  file.camera = data_->model;
  return FormatCameraFile(file, Digits::kAll);
}

template <typename Scalar>
template <typename Other>
Camera<Other> Camera<Scalar>::Cast() const {
  return Camera<Other>(Camera<Other>::Data::Make(data_->file, data_->model));
}

template <typename Scalar>
std::string Camera<Scalar>::Model() const {
  return data_->model->Name();
}
template <typename Scalar>
int Camera<Scalar>::Width() const {
  return data_->model->image_size().width;
}
template <typename Scalar>
int Camera<Scalar>::Height() const {
  return data_->model->image_size().height;
}
template <typename Scalar>
bool Camera<Scalar>::IsCentral() const {
  return data_->model->IsCentral();
}

template <typename Scalar>
Eigen::AlignedBox<Scalar, 2> Camera<Scalar>::Bounds() const {
  const Area& area = data_->model->area();
  return {Eigen::Vector2d(area.x0, area.y0).cast<Scalar>(),
          Eigen::Vector2d(area.x1, area.y1).cast<Scalar>()};
}

template <typename Scalar>
PoseTransform Camera<Scalar>::CameraFromView() const {
  const Pose pose = data_->file->camera_from_view.value_or(Pose());
  return PoseTransform(Eigen::Translation3d(pose.translation) * pose.rotation);
}

template <typename Scalar>
bool Camera<Scalar>::IsIlluminated(const Vector2& pixel) const {
  const Eigen::Vector2d at = pixel.template cast<double>();
  return data_->model->area().Contains(at) && data_->model->IsInImageCircle(at);
}

template <typename Scalar>
bool Camera<Scalar>::IsInValidRegion(const Vector2& pixel) const {
  if (!IsIlluminated(pixel)) return false;
  const auto& uncertainty = data_->file->uncertainty;
  return !uncertainty ||
         uncertainty->mask.IsValidAt(pixel.template cast<double>());
}

template <typename Scalar>
bool Camera<Scalar>::Uncertainty(const Vector2& pixel,
                                 Scalar* stddev_px) const {
  const Eigen::Vector2d at = pixel.template cast<double>();
  const auto& uncertainty = data_->file->uncertainty;
  const Area& area = data_->model->area();
  if (!uncertainty || !uncertainty->HasStdDevs() || !area.Contains(at))
    return false;
  const double deviation = uncertainty->lattice.At(area, at);
  if (!std::isfinite(deviation)) return false;
  *stddev_px = static_cast<Scalar>(deviation);
  return true;
}

template <typename Scalar>
bool Camera<Scalar>::Unproject(const Vector2& pixel, Vector3* bearing,
                               Matrix32* J_pixel) const {
  return data_->evaluator->Unproject(pixel, bearing, J_pixel);
}

template <typename Scalar>
bool Camera<Scalar>::UnprojectLine(const Vector2& pixel, Vector3* origin,
                                   Vector3* bearing, Matrix32* origin_J_pixel,
                                   Matrix32* bearing_J_pixel) const {
  return data_->evaluator->UnprojectLine(pixel, origin, bearing, origin_J_pixel,
                                         bearing_J_pixel);
}

template <typename Scalar>
bool Camera<Scalar>::Project(const Vector3& point, Vector2* pixel,
                             Matrix23* J_point,
                             IntrinsicsJacobian<Scalar>* J_intrinsics) const {
  if (!J_intrinsics) return data_->evaluator->Project(point, pixel, J_point);
  Vector2 found;
  if (!data_->evaluator->Project(point, &found, nullptr)) return false;
  LinearizedProjection projection;
  const Eigen::Vector2d start = found.template cast<double>();
  constexpr double kMarginPx = 1e-3;  // rounding at the edge
  if (!data_->model->Linearize(point.template cast<double>(), &start, kMarginPx,
                               &projection))
    return false;
  *pixel = found;
  if (J_point) *J_point = projection.J_point.template cast<Scalar>();
  CopyColumns(projection, J_intrinsics);
  return true;
}

template <typename Scalar>
int Camera<Scalar>::UnprojectAll(const Eigen::Ref<const Pixels>& pixels,
                                 Eigen::Ref<Points> bearings) const {
  const Eigen::Index count = std::min(pixels.cols(), bearings.cols());
  return data_->evaluator->UnprojectAll(
      {pixels.data(), pixels.outerStride()}, static_cast<int>(count), {},
      {bearings.data(), bearings.outerStride()});
}

template <typename Scalar>
int Camera<Scalar>::UnprojectAllLines(const Eigen::Ref<const Pixels>& pixels,
                                      Eigen::Ref<Points> origins,
                                      Eigen::Ref<Points> bearings) const {
  const Eigen::Index count =
      std::min({pixels.cols(), origins.cols(), bearings.cols()});
  return data_->evaluator->UnprojectAll(
      {pixels.data(), pixels.outerStride()}, static_cast<int>(count),
      {origins.data(), origins.outerStride()},
      {bearings.data(), bearings.outerStride()});
}

template <typename Scalar>
int Camera<Scalar>::ProjectAll(const Eigen::Ref<const Points>& points,
                               Eigen::Ref<Pixels> pixels) const {
  const Eigen::Index count = std::min(points.cols(), pixels.cols());
  return data_->evaluator->ProjectAll({points.data(), points.outerStride()},
                                      static_cast<int>(count),
                                      {pixels.data(), pixels.outerStride()});
}

template <typename Scalar>
int Camera<Scalar>::NumParameters() const {
  return data_->model->NumParameters();
}
template <typename Scalar>
void Camera<Scalar>::CopyParameters(double* parameters) const {
  const Eigen::VectorXd all = data_->model->Parameters();
  std::copy(all.begin(), all.end(), parameters);
}
template <typename Scalar>
std::vector<std::string> Camera<Scalar>::ParameterNames() const {
  const ParametricModel* parametric = data_->model->Parametric();
  return parametric ? parametric->ParameterNames() : std::vector<std::string>();
}

template <typename Scalar>
bool Camera<Scalar>::SetParameters(
    const Eigen::Ref<const Eigen::VectorXd>& parameters) {
  if (parameters.size() != NumParameters() || !parameters.allFinite())
    return false;
  std::shared_ptr<CameraModel> model = data_->model->Clone();
  model->SetParameters(parameters);
  auto evaluator = data_->evaluator->WithModel(model);
  data_ = std::make_shared<const Data>(
      Data{data_->file, std::move(model), std::move(evaluator)});
  return true;
}

template class Camera<double>;
template class Camera<float>;
template RAYGRID_HOST_API Camera<float> Camera<double>::Cast<float>() const;
template RAYGRID_HOST_API Camera<double> Camera<double>::Cast<double>() const;
template RAYGRID_HOST_API Camera<double> Camera<float>::Cast<double>() const;
template RAYGRID_HOST_API Camera<float> Camera<float>::Cast<float>() const;

}  // namespace raygrid
