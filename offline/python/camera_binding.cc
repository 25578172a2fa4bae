#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "camera/camera_frame.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/fixed_operating_point.h"
#include "evaluation/uncertainty_summary.h"
#include "exchange/format.h"
#include "exchange/table_format.h"
#include "packing/blob_camera.h"
#include "packing/pack.h"
#include "packing/view_request.h"
#include "packing/view_sources.h"
#include "python/bindings.h"
#include "python/camera_docstrings.h"
#include "python/camera_points.h"

namespace raygrid {
namespace {

const CameraUncertainty& GetUncertainty(const PyCamera& self) {
  if (self.file.uncertainty) return *self.file.uncertainty;
  throw Error(ExitCode::kUsage,
              "the camera has no uncertainty; use a camera.yaml written by "
              "raygrid calibrate");
}

DoubleArray UncertaintyAt(const PyCamera& self, const py::object& given) {
  const InputVectors pixels = ReadVectors(given, 2, "pixels");
  const CameraModel& camera = *self.file.camera;
  const UncertaintyLattice& lattice = GetUncertainty(self).lattice;
  DoubleArray deviations = pixels.Like({});
  double* const deviation = deviations.mutable_data();
  for (size_t k = 0; k < pixels.count; ++k) {
    const Eigen::Vector2d pixel(pixels[k][0], pixels[k][1]);
    deviation[k] =
        camera.area().Contains(pixel) && camera.IsInImageCircle(pixel)
            ? lattice.At(camera.area(), pixel)
            : NAN;
  }
  return deviations;
}

py::array_t<bool> IsValid(const PyCamera& self, const py::object& given) {
  const InputVectors pixels = ReadVectors(given, 2, "pixels");
  const ValidityMask& mask = GetUncertainty(self).mask;
  const CameraModel& camera = *self.file.camera;
  py::array_t<bool> valid_region(pixels.axes);
  bool* const is_valid = valid_region.mutable_data();
  for (size_t k = 0; k < pixels.count; ++k) {
    const Eigen::Vector2d pixel(pixels[k][0], pixels[k][1]);
    is_valid[k] = camera.area().Contains(pixel) && mask.IsValidAt(pixel);
  }
  return valid_region;
}

py::dict GetUncertaintyMetrics(const PyCamera& self) {
  const CameraUncertainty& known = GetUncertainty(self);
  const CameraModel& camera = *self.file.camera;
  py::dict metrics;
  metrics["median_px"] = known.lattice.MedianPx();
  metrics["valid_limit_px"] = known.max_stddev_px;
  const UncertaintySummary summary = SummarizeUncertainty(camera, known);
  metrics["valid_fraction"] = summary.valid_share;
  py::dict shares;
  for (size_t k = 0; k < kShareLimitsPx.size(); ++k)
    shares[py::float_(kShareLimitsPx[k])] = summary.share_below[k];
  metrics["fraction_below_px"] = shares;
  return metrics;
}

// ---- Files -----------------------------------------------------------------

// Reads another program's file; warns about contents that are not imported.
CameraFile ParseForeign(const std::string& path, const std::string& text,
                        const Format& format) {
  RequireCameraFormat(format, path);
  const ExchangeContents contents =
      ReadExchangeFile(&format, {path, text, "", std::nullopt});
  RequireCameras(contents, path);
  if (contents.cameras.size() != 1)
    throw InputError(fmt::format(
        "{}: has {} cameras; load them with raygrid.importers.load()", path,
        contents.cameras.size()));
  for (const std::string& warning : contents.warnings)
    Warn(fmt::format("{}: {}", path, warning));
  return MakeCameraFile(contents.cameras.front());
}

PyCamera Load(const py::object& file) {
  const std::string path = ToPath(file);
  const std::string bytes = ReadFile(path);
  if (IsBlob(path, bytes))
    throw InputError(path +
                     ": is a blob; use raygrid.Blob, the fixed-point runtime");
  if (const TableFormat* table = RecognizeTable(bytes))
    throw InputError(
        fmt::format("{}: {}", path, table->ExplainMissingCamera()));
  const Format* format = RecognizeCamera(path, bytes);
  return {format ? ParseForeign(path, bytes, *format)
                 : ParseCameraFile(path, bytes)};
}

std::vector<OperatingRange> GetRanges(const PyCamera& self) {
  if (!self.file.stack) return {};
  return self.file.stack->cameras.ranges();
}

py::tuple MakeTuple(const OperatingRange& range) {
  return py::make_tuple(OperatingParameterName(range.condition), range.low,
                        range.high);
}

py::object GetSingleRange(const PyCamera& self) {
  const std::vector<OperatingRange> ranges = GetRanges(self);
  if (ranges.size() != 1) return py::none();
  return MakeTuple(ranges[0]);
}

py::list ListRanges(const PyCamera& self) {
  py::list all;
  for (const OperatingRange& range : GetRanges(self))
    all.append(MakeTuple(range));
  return all;
}

// Returns the values for the ranges; `value` without a name applies if there is
// only one range.
FixedOperatingPoint FixRangeValues(const std::vector<OperatingRange>& ranges,
                                   std::optional<double> value,
                                   std::optional<double> lens_position,
                                   std::optional<double> temperature) {
  FixedOperatingPoint held;
  for (const OperatingRange& range : ranges) {
    std::optional<double>& named =
        range.condition == OperatingParameter::kLensPosition ? lens_position
                                                             : temperature;
    held.push_back(std::exchange(named, std::nullopt));
  }
  if (lens_position || temperature)
    throw py::value_error(
        fmt::format("the camera does not vary with {}",
                    lens_position ? "lens_position" : "temperature"));
  if (value && ranges.size() > 1)
    throw py::value_error(
        "the camera varies with two quantities: specify lens_position= and "
        "temperature=");
  if (value && held[0])
    throw py::value_error(
        "pass the operating point either as a value or as lens_position= or "
        "temperature=, not both");
  if (value) held[0] = value;
  return held;
}

PyCamera CameraAt(const PyCamera& self, std::optional<double> value,
                  std::optional<double> lens_position,
                  std::optional<double> temperature) {
  const std::vector<OperatingRange> ranges = GetRanges(self);
  if (ranges.empty())
    throw py::value_error(
        "the camera was not calibrated over a range of focus or temperature");
  const FixedOperatingPoint held =
      FixRangeValues(ranges, value, lens_position, temperature);
  for (size_t r = 0; r < ranges.size(); ++r)
    if (held[r] && !ranges[r].Contains(*held[r]))
      throw py::value_error(
          fmt::format("{:g} is outside the calibrated range, {}", *held[r],
                      ranges[r].Text()));
  return {MakeCameraFileAt(self.file, held)};
}

void Save(const PyCamera& self, const py::object& path) {
  WriteFile(ToPath(path), ToString(self));
}

// ---- Views -----------------------------------------------------------------

ImageSize ReadSize(const std::pair<int, int>& size) {
  if (size.first < 1 || size.second < 1)
    throw py::value_error(
        fmt::format("size: expected positive (width, height), not ({}, {})",
                    size.first, size.second));
  return {size.first, size.second};
}

template <int n>
std::optional<Eigen::Matrix<double, n, 1>> ReadVector(const py::object& given,
                                                      const char* name) {
  if (given.is_none()) return std::nullopt;
  const InputVectors vector = ReadVectors(given, n, name);
  if (vector.count != 1 || !vector.axes.empty())
    throw py::value_error(fmt::format("{}: expected {} numbers", name, n));
  return Eigen::Matrix<double, n, 1>(
      Eigen::Map<const Eigen::Matrix<double, n, 1>>(vector[0]));
}

void RequireNumber(const std::optional<double>& number, const char* name) {
  if (number && !std::isfinite(*number))
    throw py::value_error(fmt::format("{}: expected a finite number", name));
}

// Returns the camera, rotated to the frame in which views are defined.
std::shared_ptr<const CameraModel> GetAlignedCamera(const PyCamera& self) {
  std::shared_ptr<const CameraModel> camera = self.file.camera;
  AlignToCanonicalFrame(&camera);
  return camera;
}

VirtualView MakeVirtualView(const PyCamera& self,
                            const std::optional<std::pair<int, int>>& size,
                            const std::optional<double>& hfov,
                            const std::optional<double>& vfov,
                            const std::optional<double>& focal,
                            const std::optional<double>& alpha,
                            const py::object& center, const py::object& rotate,
                            const std::optional<std::string>& projection) {
  ViewRequest request;
  if (size) request.size = ReadSize(*size);
  for (const auto& [number, name] : {std::pair(&hfov, "hfov"),
                                     {&vfov, "vfov"},
                                     {&focal, "focal"},
                                     {&alpha, "alpha"}})
    RequireNumber(*number, name);
  request.hfov_deg = hfov;
  request.vfov_deg = vfov;
  request.focal_px = focal;
  request.alpha = alpha;
  request.center_px = ReadVector<2>(center, "center");
  request.rotate_deg = ReadVector<3>(rotate, "rotate");
  if (projection) {
    request.projection = FindProjection(*projection);
    if (!request.projection)
      throw py::value_error(
          fmt::format("projection: expected pinhole, cylindrical, "
                      "equirectangular, stereographic or equidistant, not '{}'",
                      *projection));
  }
  const bool is_given = size || hfov || vfov || focal || alpha ||
                        request.center_px || request.rotate_deg || projection;
  const py::gil_scoped_release released;
  RequireValidView(request);
  const auto camera = GetAlignedCamera(self);
  return is_given ? MakeView(*camera, request) : MakeAreaView(*camera);
}

Eigen::Matrix3d MakeViewMatrix(const VirtualView& view) {
  Eigen::Matrix3d matrix;
  matrix << view.focal_px.x(), 0, view.center_px.x(), 0, view.focal_px.y(),
      view.center_px.y(), 0, 0, 1;
  return matrix;
}

py::tuple ComputeRemapMaps(const PyCamera& self,
                           const std::optional<VirtualView>& given,
                           bool is_reverse, int num_threads) {
  ViewSources found;
  {
    const py::gil_scoped_release released;
    const auto camera = GetAlignedCamera(self);
    found = MakeViewSources(*camera, given ? *given : MakeAreaView(*camera),
                            is_reverse, num_threads);
  }
  py::array_t<float> x({found.size.height, found.size.width});
  py::array_t<float> y({found.size.height, found.size.width});
  float* const to_x = x.mutable_data();
  float* const to_y = y.mutable_data();
  for (size_t k = 0; k < found.sources.size(); ++k) {
    const bool is_known = !found.sources[k].hasNaN();
    to_x[k] = is_known ? static_cast<float>(found.sources[k].x()) : -1.0f;
    to_y[k] = is_known ? static_cast<float>(found.sources[k].y()) : -1.0f;
  }
  return py::make_tuple(x, y);
}

py::bytes Pack(const PyCamera& self, const std::vector<VirtualView>& views,
               double max_error_px, int num_threads) {
  PackedCamera packed;
  RunInBackground(py::none(), [&](Task* task) {
    CameraFile file = self.file;
    // The cameras of the other operating points would have to be rotated as
    // well.
    if (AlignToCanonicalFrame(&file.camera)) file.stack.reset();
    PackOptions options;
    for (const VirtualView& view : views) options.remaps.emplace_back(view);
    options.has_default_remap = views.empty();
    options.max_error_px = max_error_px;
    options.num_threads = num_threads;
    options.should_stop = [task] { return task->ShouldStop(); };
    packed = PackCamera(file, options);
  });
  for (const std::string& warning : packed.warnings) Warn(warning);
  return packed.blob;
}

// ---- Properties ------------------------------------------------------------

py::dict GetParameterDict(const PyCamera& self) {
  py::dict named;
  const ParametricModel* lens = self.file.camera->Parametric();
  if (!lens) return named;
  const Eigen::VectorXd values = lens->Parameters();
  const std::vector<std::string>& names = lens->ParameterNames();
  const Eigen::Index first =
      values.size() - static_cast<Eigen::Index>(names.size());
  for (size_t k = 0; k < names.size(); ++k)
    named[py::str(names[k])] = values[first + static_cast<Eigen::Index>(k)];
  return named;
}

py::object GetImageCircle(const PyCamera& self) {
  const auto& circle = self.file.camera->image_circle();
  if (!circle) return py::none();
  return py::make_tuple(circle->center.x(), circle->center.y(),
                        circle->radii_px.x(), circle->radii_px.y());
}

}  // namespace

void BindView(py::module_* module) {
  py::class_<VirtualView>(
      *module, "View",
      "An output view: the virtual camera of undistorted images, "
      "made by Camera.view(); immutable.")
      .def_property_readonly(
          "size",
          [](const VirtualView& v) {
            return py::make_tuple(v.size.width, v.size.height);
          },
          "(width, height) of the undistorted images, in pixels.")
      .def_property_readonly(
          "projection",
          [](const VirtualView& v) { return ProjectionName(v.projection); },
          "'pinhole', 'cylindrical', 'equirectangular', 'stereographic' or "
          "'equidistant'.")
      .def_property_readonly(
          "K", [](const VirtualView& v) { return ReadOnly(MakeViewMatrix(v)); },
          "Camera matrix (3, 3) in pixels (for other projections than pinhole "
          "pixels per radian at the centre); (0, 0) is the centre of the "
          "top-left pixel.")
      .def_property_readonly(
          "camera_from_view",
          [](const VirtualView& v) { return ReadOnly(v.camera_from_view); },
          "Rotation (3, 3) from axes of the output view to camera axes.")
      .def_property_readonly("hfov_deg", &VirtualView::HorizontalFieldOfViewDeg,
                             "Horizontal field of view in degrees.")
      .def_property_readonly("vfov_deg", &VirtualView::VerticalFieldOfViewDeg,
                             "Vertical field of view in degrees.")
      .def(
          "camera",
          [](const VirtualView& view) {
            CameraFile file;
            file.camera = MakeViewCamera(view);
            if (view.IsTurned())
              file.camera_from_view =
                  Pose{Eigen::Quaterniond(view.camera_from_view), {0, 0, 0}};
            return PyCamera{file};
          },
          "The output view as a Camera, in its own axes.")
      .def("__repr__", [](const VirtualView& v) {
        return fmt::format("<raygrid.View {} {} x {}, {:.1f} x {:.1f} degrees>",
                           ProjectionName(v.projection), v.size.width,
                           v.size.height, v.HorizontalFieldOfViewDeg(),
                           v.VerticalFieldOfViewDeg());
      });
}

void BindCamera(py::module_* module) {
  const auto get_size = [](const PyCamera& c) {
    const ImageSize& size = c.file.camera->image_size();
    return py::make_tuple(size.width, size.height);
  };
  const auto get_area = [](const PyCamera& c) {
    const Area& area = c.file.camera->area();
    return py::make_tuple(area.x0, area.y0, area.x1, area.y1);
  };
  py::class_<PyCamera>(*module, "Camera", docstring::kCamera)
      .def_static("load", &Load, py::arg("path"), docstring::kLoad)
      .def("save", &Save, py::arg("path"), docstring::kSave)
      .def("at", &CameraAt, py::arg("value") = py::none(), py::kw_only(),
           py::arg("lens_position") = py::none(),
           py::arg("temperature") = py::none(), docstring::kAt)
      .def_property_readonly(
          "range", &GetSingleRange,
          "Range of operating points, as ('lens_position', lowest, highest) in "
          "dioptres or ('temperature', lowest, highest) in degrees Celsius. "
          "None without a range, or with two.")
      .def_property_readonly("ranges", &ListRanges,
                             "List of all ranges, each in the form of range.")
      .def("project", &Project, py::arg("points"), py::kw_only(),
           py::arg("jacobians") = false, py::arg("threads") = 0,
           docstring::kProject)
      .def("unproject", &Unproject, py::arg("pixels"), py::kw_only(),
           py::arg("jacobians") = false, py::arg("threads") = 0,
           docstring::kUnproject)
      .def("rays", &Rays, py::arg("pixels"), py::kw_only(),
           py::arg("threads") = 0, docstring::kRays)
      .def("uncertainty", &UncertaintyAt, py::arg("pixels"),
           docstring::kUncertainty)
      .def("is_valid", &IsValid, py::arg("pixels"), docstring::kIsValid)
      // The former name of is_valid.
      .def("is_trusted", &IsValid, py::arg("pixels"),
           "Deprecated: use is_valid().")
      .def_property_readonly("uncertainty_figures", &GetUncertaintyMetrics,
                             docstring::kUncertaintyFigures)
      .def("view", &MakeVirtualView, py::kw_only(),
           py::arg("size") = py::none(), py::arg("hfov") = py::none(),
           py::arg("vfov") = py::none(), py::arg("focal") = py::none(),
           py::arg("alpha") = py::none(), py::arg("center") = py::none(),
           py::arg("rotate") = py::none(), py::arg("projection") = py::none(),
           docstring::kView)
      .def("maps", &ComputeRemapMaps, py::arg("view") = py::none(),
           py::kw_only(), py::arg("reverse") = false, py::arg("threads") = 0,
           docstring::kMaps)
      .def("pack", &Pack, py::arg("views") = std::vector<VirtualView>(),
           py::kw_only(), py::arg("max_error_px") = 0.05,
           py::arg("threads") = 0, docstring::kPack)
      .def_property_readonly(
          "model", [](const PyCamera& c) { return c.file.camera->Name(); },
          "Name of the camera model, such as 'central-generic'.")
      .def_property_readonly("size", get_size,
                             "(width, height) of the images, in pixels.")
      .def_property_readonly(
          "area", get_area,
          "Calibrated area (x0, y0, x1, y1) in pixels, inclusive.")
      .def_property_readonly(
          "image_circle", &GetImageCircle,
          "Image circle of a fisheye, (x, y, radius_x, radius_y) in pixels; "
          "None if it covers the image or is unknown.")
      .def_property_readonly(
          "is_central",
          [](const PyCamera& c) { return c.file.camera->IsCentral(); },
          "Whether all rays start at the origin.")
      .def_property_readonly(
          "name", [](const PyCamera& c) { return c.file.name; },
          "Name of the camera; may be empty.")
      .def_property_readonly(
          "serial", [](const PyCamera& c) { return c.file.serial; },
          "Serial number of the camera; may be empty.")
      .def_property_readonly(
          "verdict", [](const PyCamera& c) { return c.file.assessment; },
          "Status of the calibration, 'pass', 'warn' or 'fail'; empty if "
          "unknown.")
      .def_property_readonly(
          "parameters",
          [](const PyCamera& c) {
            const Eigen::VectorXd values = c.file.camera->Parameters();
            return ReadOnlyVector(values.data(),
                                  static_cast<size_t>(values.size()));
          },
          "All parameters (N,) of the camera model; read-only.")
      .def_property_readonly(
          "named_parameters", &GetParameterDict,
          "Parameters of a parametric model by name, such as fx, fy, cx and cy "
          "in pixels. Empty for a generic model.")
      .def("__repr__", [](const PyCamera& c) {
        const ImageSize& size = c.file.camera->image_size();
        return fmt::format("<raygrid.Camera {} {} x {}>", c.file.camera->Name(),
                           size.width, size.height);
      });
}

}  // namespace raygrid
