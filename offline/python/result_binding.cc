#include <fmt/format.h>

#include "dataset/files.h"
#include "dataset/output_folder.h"
#include "packing/pack.h"
#include "python/bindings.h"
#include "report/result_folder.h"

namespace raygrid {

size_t PyCalibration::IndexOf(const std::string& name) const {
  if (name.empty() && !result.IsRig()) return 0;
  for (size_t c = 0; c < result.cameras.size(); ++c)
    if (result.cameras[c].camera.name == name) return c;
  throw py::key_error("unknown camera '" + name + "'");
}

namespace {

// ---- Metrics ---------------------------------------------------------------

py::tuple Residuals(const std::vector<FeatureResidual>& residuals) {
  const auto count = static_cast<py::ssize_t>(residuals.size());
  DoubleArray pixels({count, py::ssize_t{2}}), errors({count, py::ssize_t{2}});
  for (py::ssize_t k = 0; k < count; ++k)
    for (int axis = 0; axis < 2; ++axis) {
      const FeatureResidual& residual = residuals[static_cast<size_t>(k)];
      pixels.mutable_at(k, axis) = residual.pixel[axis];
      errors.mutable_at(k, axis) = residual.error_px[axis];
    }
  return py::make_tuple(pixels, errors);
}

py::list ListPoses(const PyCalibration& self, const std::string& camera) {
  py::list poses;
  for (const BoardPose& pose : self.result.cameras[self.IndexOf(camera)].poses)
    poses.append(py::make_tuple(pose.image, pose.board,
                                ReadOnly(ToMatrix(pose.camera_from_board))));
  return poses;
}

py::list GetFeatures(const PyCalibration& self, const std::string& camera) {
  py::list detections;
  const Dataset& dataset = self.result.cameras[self.IndexOf(camera)].features;
  for (const ImageFeatures& image : dataset.images)
    detections.append(PyDetection{dataset.image_size, image, {}});
  return detections;
}

py::dict ListCameras(const PyCalibration& self) {
  py::dict cameras;
  for (const CalibrationResult& camera : self.result.cameras)
    cameras[py::str(camera.camera.name)] = PyCamera{camera.camera};
  return cameras;
}

py::dict CameraFromRig(const PyCalibration& self) {
  py::dict poses;
  for (size_t c = 0; c < self.result.cameras.size(); ++c)
    poses[py::str(self.result.cameras[c].camera.name)] = ReadOnly(ToMatrix(
        self.result.IsRig() ? self.result.camera_from_rig[c] : Pose{}));
  return poses;
}

py::dict GetCovariances(const PyCalibration& self) {
  py::dict covariances;
  for (const Baseline& pair : self.result.baselines)
    if (pair.covariance)
      covariances[py::make_tuple(
          self.result.cameras[pair.first].camera.name,
          self.result.cameras[pair.second].camera.name)] =
          ReadOnly(*pair.covariance);
  return covariances;
}

// ---- Result folder ---------------------------------------------------------

ResultExtras PackResult(const PyCalibration& self, const Task* task) {
  ResultExtras extras;
  for (const CalibrationResult& camera : self.result.cameras) {
    CameraExtras& own = extras.cameras.emplace_back();
    const PackedCamera packed = PackSupportedSections(
        camera.camera, self.num_threads, [task] { return task->ShouldStop(); });
    task->ThrowIfInterrupted();
    own.packing = ComputePackingMetrics(packed);
    own.blob = packed.blob;
    if (!packed.remaps.empty())
      own.view = ViewCameraFile(packed.remaps[0].view, camera.camera.name);
  }
  return extras;
}

// Writes the folder atomically: it contains either all files of the result, or
// its previous files.
void SaveResult(const PyCalibration& self, const py::object& path) {
  const std::string folder = ToPath(path);
  RunInBackground(py::none(), [&](Task* task) {
    const ResultExtras extras = PackResult(self, task);
    OutputFolder output(folder);
    OutputFiles files;
    AddResultFiles(self.result, extras, output.path(), &files);
    files.Commit();
    AddReports(output.path(), &files);
    files.Commit();
    task->ThrowIfInterrupted();
    output.Commit(ResultFiles(folder));
  });
}

}  // namespace

void BindResult(py::module_* module) {
  const auto first_camera = [](const PyCalibration& c) {
    return PyCamera{c.result.cameras.front().camera};
  };
  const auto residuals =
      [](std::vector<FeatureResidual> CalibrationResult::*member) {
        return [member](const PyCalibration& c, const std::string& camera) {
          return Residuals(c.result.cameras[c.IndexOf(camera)].*member);
        };
      };
  py::class_<PyCalibration>(*module, "Calibration",
                            R"(Result of calibrate().

Methods with the argument camera take the name of a camera of a rig; the default
is the only camera. An unknown name raises KeyError.)")
      .def_property_readonly("camera", first_camera,
                             "The camera; for a rig the first one.")
      .def_property_readonly("cameras", &ListCameras,
                             "Dict of the cameras by name; '' if it has none.")
      .def_property_readonly(
          "camera_from_rig", &CameraFromRig,
          "Dict of the poses (4, 4) by camera name, homogeneous "
          "transformations in metres from the rig's frame, which is that of "
          "the first camera, to camera axes.")
      .def_property_readonly(
          "relative_pose_covariances", &GetCovariances,
          "Dict of the covariances (6, 6) by (first, second) camera of a rig, "
          "of the rotation vector r (rad) and the translation d (m) of "
          "exp(r) R, t + d for second_from_first.")
      .def_property_readonly(
          "verdict",
          [](const PyCalibration& c) { return c.result.assessment.word; },
          "Status, 'pass', 'warn' or 'fail'.")
      .def_property_readonly(
          "reasons",
          [](const PyCalibration& c) { return c.result.assessment.reasons; },
          "List of the reasons for the status, one line each.")
      .def_property_readonly(
          "result_json",
          [](const PyCalibration& c) {
            return FormatResultJson(c.result, 0, 0);
          },
          "Text of result.json, without the results of packing.")
      .def_property_readonly(
          "pattern",
          [](const PyCalibration& c) {
            return FormatPattern(c.result.pattern);
          },
          "Text of pattern.yaml, with the estimated target geometry in metres.")
      .def("training", residuals(&CalibrationResult::training),
           py::arg("camera") = "",
           R"(Residuals of the features used for the calibration.

Returns:
    Observed pixels and errors (projected minus observed), both (N, 2), in
    pixels.)")
      .def("held_out", residuals(&CalibrationResult::held_out),
           py::arg("camera") = "",
           R"(Residuals of held-out images, or else of cross-validation.

Returns:
    Observed pixels and errors (projected minus observed), both (N, 2), in
    pixels.)")
      .def("poses", &ListPoses, py::arg("camera") = "",
           R"(Poses of the boards in the images.

Returns:
    List of (image, board, camera_from_board), with the name of the image, the
    id of the board, and the homogeneous transformation (4, 4) in metres.)")
      .def("features", &GetFeatures, py::arg("camera") = "",
           R"(Refined features used for the calibration.

Returns:
    List with a Detection of each image.)")
      .def("save", &SaveResult, py::arg("folder"),
           R"(Write the folder of 'raygrid calibrate', completely or not at all.

The report has no pictures of the images.

Args:
    folder: the folder to write or replace.

Raises:
    Error: the folder cannot be written.)")
      .def("__repr__", [](const PyCalibration& c) {
        return fmt::format("<raygrid.Calibration {}, {} camera{}>",
                           c.result.assessment.word, c.result.cameras.size(),
                           c.result.cameras.size() == 1 ? "" : "s");
      });
}

}  // namespace raygrid
