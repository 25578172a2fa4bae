#include "exchange/colmap_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "exchange/colmap_files.h"
#include "exchange/opencv_forms.h"

namespace raygrid {
namespace {

LensForm ColmapForm(LensForm form, bool is_only_asked) {
  form.origin = PixelOrigin::kImageCorner;
  form.reach_rad = M_PI / 2;
  form.is_only_asked = is_only_asked;
  return form;
}

// COLMAP's fisheyes divide by z, as OpenCV's. The models with one focal length
// are those of more parameters; versions before 4 lack the last three.
std::vector<LensForm> MakeColmapForms() {
  const std::string fisheye = "thin-prism-fisheye";
  std::vector<LensForm> forms = {
      ColmapForm(OpenCvForm("PINHOLE", 0), false),
      ColmapForm(OpenCvForm("OPENCV", 4), false),
      ColmapForm(OpenCvForm("FULL_OPENCV", 8), false),
      ColmapForm(OpenCvFisheyeForm("OPENCV_FISHEYE"), false),
      ColmapForm(FormOf("THIN_PRISM_FISHEYE", fisheye,
                        {"k1", "k2", "p1", "p2", "k3", "k4", "sx1", "sy1"}),
                 false)};
  const std::vector<LensForm> asked = {
      {"SIMPLE_PINHOLE", "opencv", {"f", "cx", "cy"}},
      {"SIMPLE_RADIAL", "opencv", {"f", "cx", "cy", "k1"}},
      {"RADIAL", "opencv", {"f", "cx", "cy", "k1", "k2"}},
      {"SIMPLE_RADIAL_FISHEYE", fisheye, {"f", "cx", "cy", "k1"}},
      {"RADIAL_FISHEYE", fisheye, {"f", "cx", "cy", "k1", "k2"}},
      {"SIMPLE_FISHEYE", fisheye, {"f", "cx", "cy"}},
      {"FISHEYE", fisheye, {"fx", "fy", "cx", "cy"}},
      FormOf("EUCM", "eucm", {"alpha", "beta"})};
  for (const LensForm& form : asked) forms.push_back(ColmapForm(form, true));
  return forms;
}

const std::vector<LensForm>& ColmapForms() {
  static const std::vector<LensForm> forms = MakeColmapForms();
  return forms;
}

const LensForm& ColmapFormNamed(const ColmapCamera& camera) {
  std::string names;
  for (const LensForm& form : ColmapForms()) {
    if (form.name == camera.model) return form;
    names += (names.empty() ? "" : ", ") + form.name;
  }
  const std::vector<std::string>& known = ColmapModelNames();
  const bool is_known =
      std::find(known.begin(), known.end(), camera.model) != known.end();
  throw InputError(fmt::format(
      "camera {}: {} {}; models that are: {}", camera.id,
      Printable(camera.model),
      is_known ? "is a model that raygrid has not" : "is no model of COLMAP",
      names));
}

bool IsBinaryPath(const std::string& path) {
  return std::filesystem::path(path).extension() == ".bin";
}

std::string RigsPath(const std::string& path) {
  return std::filesystem::path(path)
      .replace_filename(IsBinaryPath(path) ? "rigs.bin" : "rigs.txt")
      .string();
}

// The one rig of several cameras, if all have poses in it; else nothing, with
// a remark if there is any such rig.
ColmapRig RigOf(const std::vector<ColmapRig>& rigs, size_t num_cameras,
                std::vector<std::string>* remarks) {
  std::vector<ColmapRig> wide;
  for (const ColmapRig& rig : rigs)
    if (rig.size() > 1) wide.push_back(rig);
  if (wide.empty()) return {};
  const bool has_poses = std::all_of(
      wide.front().begin(), wide.front().end(), [](const ColmapSensor& sensor) {
        return sensor.sensor_from_rig.has_value();
      });
  if (wide.size() == 1 && wide.front().size() == num_cameras && has_poses)
    return wide.front();
  remarks->push_back(
      "the poses in its rigs are not taken, since they are not those of all "
      "cameras in one rig");
  return {};
}

void SetPoses(const ColmapRig& rig, const std::vector<ColmapCamera>& cameras,
              ExchangeContents* contents) {
  for (const ColmapSensor& sensor : rig) {
    const auto camera = std::find_if(
        cameras.begin(), cameras.end(),
        [&](const ColmapCamera& known) { return known.id == sensor.camera; });
    if (camera == cameras.end())
      throw InputError(fmt::format("a rig has camera {}, which is not there",
                                   sensor.camera));
    contents->cameras[camera - cameras.begin()].camera_from_rig =
        sensor.sensor_from_rig;
  }
}

ExchangeContents ReadColmap(const ReadRequest& request) {
  const bool is_text = IsColmapText(request.text);
  const std::vector<ColmapCamera> cameras =
      is_text ? ParseColmapCameras(request.path, request.text)
              : DecodeColmapCameras(request.text);
  if (cameras.empty()) throw InputError("no camera in it");
  ExchangeContents contents;
  std::set<uint32_t> ids;
  for (const ColmapCamera& camera : cameras) {
    if (!ids.insert(camera.id).second)
      throw InputError(fmt::format("camera {} is there twice", camera.id));
    ReadLens read;
    read.name = camera.name.empty() && cameras.size() > 1
                    ? fmt::format("camera{}", camera.id)
                    : camera.name;
    read.serial = camera.serial;
    read.lens = {&ColmapFormNamed(camera), camera.size, camera.parameters};
    contents.cameras.push_back(std::move(read));
  }
  if (!request.beside.empty()) {
    const std::string path = RigsPath(request.path);
    SetPoses(RigOf(is_text ? ParseColmapRigs(path, request.beside)
                           : DecodeColmapRigs(request.beside),
                   cameras.size(), &contents.remarks),
             cameras, &contents);
  }
  return contents;
}

std::string WriteColmap(const WriteRequest& request) {
  std::vector<ColmapCamera> cameras;
  for (const WrittenLens& camera : request.cameras)
    cameras.push_back({static_cast<uint32_t>(cameras.size() + 1),
                       camera.lens.form->name, camera.lens.size,
                       camera.lens.values, camera.name, camera.serial,
                       camera.fit ? LensFitText(*camera.fit) : ""});
  return IsBinaryPath(request.path) ? EncodeColmapCameras(cameras)
                                    : FormatColmapCameras(cameras);
}

// COLMAP's rigs stand in the frame of their first sensor.
std::string WriteColmapRig(const WriteRequest& request) {
  const Pose rig_from_first =
      request.cameras.front().camera_from_rig.value().Inverse();
  ColmapRig rig;
  for (const WrittenLens& camera : request.cameras)
    rig.push_back({static_cast<uint32_t>(rig.size() + 1),
                   *camera.camera_from_rig * rig_from_first});
  return IsBinaryPath(request.path) ? EncodeColmapRig(rig)
                                    : FormatColmapRig(rig);
}

}  // namespace

Format ColmapFormat() {
  Format format;
  format.name = "colmap";
  format.holds =
      "cameras.txt or, by its ending, cameras.bin; of a rig rigs.txt or "
      "rigs.bin beside it";
  format.forms = ColmapForms();
  format.holds_rigs = true;
  format.recognizes = [](const std::string& text) {
    return IsColmapText(text) || IsColmapBinary(text);
  };
  format.read = ReadColmap;
  format.write = WriteColmap;
  format.beside = RigsPath;
  format.write_beside = WriteColmapRig;
  return format;
}

}  // namespace raygrid
