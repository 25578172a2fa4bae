#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <set>

#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/rig_file.h"
#include "exchange/format.h"
#include "python/bindings.h"

namespace raygrid {
namespace {

namespace fs = std::filesystem;

// A camera of a file with its name and pose, from which Python creates a Rig.
using NamedCamera = std::tuple<std::string, PyCamera, std::optional<Pose>>;

py::tuple ToPython(const NamedCamera& camera) {
  const auto& [name, file, pose] = camera;
  return py::make_tuple(
      name, file, pose ? py::object(ReadOnly(ToMatrix(*pose))) : py::none());
}

Pose PoseFromMatrix(const py::object& given, const std::string& name) {
  const InputVectors rows = ReadVectors(given, 4, name);
  if (rows.count != 4)
    throw py::value_error(name + ": expected a matrix of the shape (4, 4)");
  const Eigen::Matrix4d matrix =
      Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(rows[0]);
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  constexpr double kRounding = 1e-6;
  if (!(rotation * rotation.transpose()).isIdentity(kRounding) ||
      rotation.determinant() < 0 ||
      !matrix.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1), kRounding))
    throw py::value_error(
        name + ": expected a rotation and a translation, as [[R, t], [0, 1]]");
  return {Eigen::Quaterniond(rotation).normalized(),
          matrix.topRightCorner<3, 1>()};
}

// ---- Import ----------------------------------------------------------------

ExchangeContents ReadSingleCamera(const std::string& path, const Format* format,
                                  const std::string& model,
                                  const std::optional<ImageSize>& size) {
  ReadRequest request = {path, ReadFile(path), model, size};
  const Format* const found = format ? format : RecognizeFormat(request.text);
  if (found) RequireCameraFormat(*found, path);
  if (found) request.beside = ReadCompanionFiles(*found, path);
  ExchangeContents contents = ReadExchangeFile(format, request);
  if (!contents.second_from_first) RequireCameras(contents, path);
  return contents;
}

// Reads all files; cameras are named after the files unless every camera has a
// name in its file.
ExchangeContents ReadAll(const std::vector<std::string>& paths,
                         const Format* format, const std::string& model,
                         const std::optional<ImageSize>& size) {
  ExchangeContents all;
  std::vector<std::string> stems;
  std::set<std::string> names;
  std::string pose_text;
  for (const std::string& path : paths) {
    ExchangeContents contents = ReadSingleCamera(path, format, model, size);
    if (contents.second_from_first) {
      all.second_from_first = contents.second_from_first;
      pose_text = path;
    }
    for (const std::string& warning : contents.warnings)
      all.warnings.push_back(path + ": " + warning);
    for (InputCamera& camera : contents.cameras) {
      stems.push_back(fs::path(path).stem().string());
      names.insert(camera.name);
      all.cameras.push_back(std::move(camera));
    }
  }
  AssignPairPose(all.second_from_first, pose_text, &all.cameras);
  if (paths.size() == 1) return all;
  if (names.size() < all.cameras.size() || names.count("") > 0)
    for (size_t c = 0; c < stems.size(); ++c) all.cameras[c].name = stems[c];
  if (!all.IsRig()) ComputeStereoPoses(&all.cameras);
  return all;
}

py::list Import(const std::vector<py::object>& files, const std::string& format,
                const std::string& model,
                const std::optional<std::pair<int, int>>& size) {
  std::vector<std::string> paths;
  for (const py::object& file : files) paths.push_back(ToPath(file));
  if (paths.empty()) throw py::value_error("paths: empty");
  const Format* const known =
      format.empty() ? nullptr : &FindFormat("format", format);
  if (known && !known->read)
    throw Error(ExitCode::kUsage,
                fmt::format("format {}: export only", known->name));
  std::optional<ImageSize> image_size;
  if (size) image_size = ImageSize{size->first, size->second};
  const ExchangeContents contents = ReadAll(paths, known, model, image_size);
  for (const std::string& warning : contents.warnings) Warn(warning);
  const bool is_rig = contents.IsRig();
  py::list cameras;
  for (const InputCamera& camera : contents.cameras)
    cameras.append(ToPython({camera.name, PyCamera{MakeCameraFile(camera)},
                             is_rig ? camera.camera_from_rig : std::nullopt}));
  return cameras;
}

// ---- Export ----------------------------------------------------------------

OutputCamera SelectModels(
    const PyCamera& camera, const std::string& name,
    const std::vector<const ExternalModel*>& external_models,
    const std::optional<Pose>& pose,
    const std::optional<double>& max_fit_error_px) {
  const auto& uncertainty = camera.file.uncertainty;
  const ValidityMask* mask = uncertainty ? &uncertainty->mask : nullptr;
  SelectedModel chosen =
      SelectExternalModel(external_models, *camera.file.camera,
                          mask && mask->HasValidCells() ? mask : nullptr);
  if (max_fit_error_px && chosen.fit &&
      (chosen.fit->num_unrepresentable > 0 ||
       chosen.fit->max_px > *max_fit_error_px))
    throw Error(
        ExitCode::kQualityTooLow,
        fmt::format("the fit error of {} exceeds max_fit_error {:g}: {}",
                    chosen.lens.external_model->name, *max_fit_error_px,
                    FormatModelFit(*chosen.fit)));
  OutputCamera lens;
  lens.name = name;
  lens.serial = camera.file.serial;
  lens.lens = chosen.lens;
  lens.fit = chosen.fit;
  lens.camera_from_rig = pose;
  if (mask) lens.valid_region = *mask;
  if (lens.fit && pose)
    lens.camera_from_rig =
        Pose{lens.fit->fitted_from_camera, Eigen::Vector3d::Zero()} * *pose;
  return lens;
}

py::object ComputeFitMetrics(const OutputCamera& lens) {
  py::dict metrics;
  metrics["model"] = lens.lens.external_model->name;
  metrics["exact"] = !lens.fit.has_value();
  if (lens.fit) {
    metrics["rms_px"] = lens.fit->rms_px;
    metrics["max_px"] = lens.fit->max_px;
    metrics["lens_from_camera"] =
        ReadOnly(lens.fit->fitted_from_camera.toRotationMatrix());
  }
  return std::move(metrics);
}

// Exports cameras given as tuples (name, camera, camera_from_rig or None).
py::list Export(const std::vector<py::tuple>& cameras, const py::object& file,
                const std::string& to, const std::string& model,
                const std::optional<double>& max_fit_error) {
  const Format& format = FindFormat("format", to);
  if (!format.write)
    throw Error(ExitCode::kUsage,
                fmt::format("format {}: import only", format.name));
  if (cameras.size() > 1 && !format.supports_rigs)
    throw Error(ExitCode::kUsage,
                fmt::format("format {}: supports one camera per file; save the "
                            "cameras of a rig separately",
                            format.name));
  const std::vector<const ExternalModel*> external_models =
      format.FindModels(model);
  WriteRequest request;
  request.path = ToPath(file);
  py::list metrics;
  for (const py::tuple& camera : cameras) {
    std::optional<Pose> pose;
    if (!camera[2].is_none())
      pose = PoseFromMatrix(camera[2], "camera_from_rig");
    request.cameras.push_back(SelectModels(
        camera[1].cast<const PyCamera&>(), camera[0].cast<std::string>(),
        external_models, pose, max_fit_error));
    metrics.append(ComputeFitMetrics(request.cameras.back()));
  }
  OutputFiles files;
  for (const auto& [path, text] : WriteWithCompanions(format, request))
    files.Add(path, text);
  files.Commit();
  return metrics;
}

py::list ListFormats() {
  py::list formats;
  for (const Format& format : GetFormats()) {
    py::list models;
    for (const ExternalModel& external_model : format.external_models)
      models.append(external_model.name);
    formats.append(py::make_tuple(
        format.name, format.holds, models, format.read != nullptr,
        format.write != nullptr, format.supports_rigs));
  }
  return formats;
}

// ---- Rigs ------------------------------------------------------------------

py::list ReadRig(const py::object& file) {
  const std::string path = ToPath(file);
  py::list cameras;
  for (const RigFileCamera& camera : ReadRigFile(path)) {
    const std::string own =
        (fs::path(path).parent_path() / camera.file).string();
    cameras.append(ToPython(
        {camera.name, PyCamera{ReadCameraFile(own)}, camera.camera_from_rig}));
  }
  return cameras;
}

py::dict ReadRigCovariances(const py::object& file) {
  const std::string path = ToPath(file);
  py::dict covariances;
  for (const RelativePoseCovariance& pose :
       ParseRelativePoseCovariances(path, ReadFile(path)))
    covariances[py::make_tuple(pose.first, pose.second)] =
        ReadOnly(pose.covariance);
  return covariances;
}

void WriteRig(const py::object& file, const std::vector<py::tuple>& cameras,
              const std::map<std::pair<std::string, std::string>, py::object>&
                  covariances) {
  const std::string path = ToPath(file);
  const fs::path folder = fs::path(path).parent_path();
  OutputFiles files;
  std::vector<RigFileCamera> rig;
  for (const py::tuple& camera : cameras) {
    const std::string name = camera[0].cast<std::string>();
    if (!IsRigCameraName(name))
      throw py::value_error(fmt::format(
          "camera name '{}': use only letters, digits, '-' and '_'", name));
    rig.push_back({name, name + "/camera.yaml",
                   PoseFromMatrix(camera[2], "camera_from_rig")});
    files.Add((folder / rig.back().file).string(),
              ToString(camera[1].cast<const PyCamera&>()));
  }
  std::vector<RelativePoseCovariance> pairs;
  for (const auto& [names, given] : covariances) {
    const InputVectors rows = ReadVectors(given, 6, "covariance");
    if (rows.count != 6)
      throw py::value_error("covariance: expected the shape (6, 6)");
    RelativePoseCovariance& pair =
        pairs.emplace_back(RelativePoseCovariance{names.first, names.second});
    for (int i = 0; i < 6; ++i)
      for (int k = 0; k < 6; ++k) pair.covariance(i, k) = rows[i][k];
  }
  const std::string text = FormatRigFile(rig, pairs);
  ParseRigFile(path, text);  // rejects what cannot be read
  files.Add(path, text);
  files.Commit();
}

}  // namespace

void BindExchange(py::module_* module) {
  module->def("import_cameras", &Import, py::arg("paths"), py::arg("format"),
              py::arg("model"), py::arg("size"),
              "(name, camera, camera_from_rig or None) of each camera.");
  module->def(
      "export_cameras", &Export, py::arg("cameras"), py::arg("path"),
      py::arg("format"), py::arg("model"), py::arg("max_fit_error"),
      "Write cameras returned by import_cameras(); returns the fit errors.");
  module->def("list_formats", &ListFormats,
              "(name, contents, models, can be read, can be written, supports "
              "rigs) of each format.");
  module->def("read_rig", &ReadRig, py::arg("path"),
              "(name, camera, camera_from_rig) of each camera.");
  module->def("read_rig_covariances", &ReadRigCovariances, py::arg("path"),
              R"(Covariances (6, 6) of the relative poses in rig.yaml.

Keys are (first, second). The order is rotation vector (rad), then translation
(m), of the update exp(r) R, t + d of second_from_first. Empty if the file has
none.)");
  module->def("write_rig", &WriteRig, py::arg("path"), py::arg("cameras"),
              py::arg("covariances"),
              "Write cameras returned by read_rig(), and rig.yaml.");
}

}  // namespace raygrid
