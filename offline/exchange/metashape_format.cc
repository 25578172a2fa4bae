#include "exchange/metashape_format.h"

#include <fmt/format.h>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "exchange/camera_keys.h"
#include "exchange/opencv_model_list.h"
#include "exchange/xml.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

constexpr char kRoot[] = "calibration", kDocument[] = "document";

// p1 and p2 are swapped relative to OpenCV and raygrid. Metashape distorts the
// normalized coordinates x / z and y / z of frame cameras; for fisheye cameras,
// these are scaled to the incidence angle. Frame cameras have fx = f + b1 and
// fy = f.
const std::vector<ExternalModel>& GetMetashapeModels() {
  static const std::vector<ExternalModel> external_models = [] {
    std::vector<ExternalModel> made = {
        MakeExternalModel("frame", models::kOpenCv,
                          {"k1", "k2", "k3", "p2", "p1"}),
        MakeExternalModel("fisheye", models::kThinPrismFisheye,
                          {"k1", "k2", "k3", "k4", "p2", "p1"})};
    for (ExternalModel& external_model : made) {
      external_model.origin = PixelOrigin::kImageCenter;
      external_model.max_supported_angle_rad = M_PI / 2;
    }
    return made;
  }();
  return external_models;
}

// Returns the metashape's names of a model's coefficients, in the order of the
// model.
std::vector<std::string> ListKeys(const ExternalModel& external_model) {
  return external_model.Has("k4")
             ? std::vector<std::string>{"k1", "k2", "k3", "k4", "p1", "p2"}
             : std::vector<std::string>{"k1", "k2", "k3", "p1", "p2"};
}

// ---- Reading ---------------------------------------------------------------

// Returns a parameter; Metashape omits parameters that are 0.
double ReadNumber(const CameraKeys& keys, const std::string& name) {
  return keys.Has(name) ? FiniteNumber(keys[name], name) : 0;
}

double RequiredNumber(const CameraKeys& keys, const std::string& name) {
  if (!keys.Has(name)) throw InputError(fmt::format("'{}' is missing", name));
  return FiniteNumber(keys[name], name);
}

const ExternalModel& FindMetashapeModel(const std::string& name) {
  const std::vector<ExternalModel>& external_models = GetMetashapeModels();
  if (name.empty() || name == "frame") return external_models[0];
  if (name == "fisheye" || name == "equidistant_fisheye")
    return external_models[1];
  throw InputError(
      fmt::format("unsupported projection '{}'; supported are frame, fisheye "
                  "and equidistant_fisheye",
                  Printable(name)));
}

// Throws for non-zero parameters that the model does not support.
void RequireOnlyKnownKeys(const CameraKeys& keys,
                          const ExternalModel& external_model) {
  std::vector<std::string> others = {"p3", "p4"};
  if (!external_model.Has("k4")) others.push_back("k4");
  for (const std::string& name : others)
    if (ReadNumber(keys, name) != 0)
      throw InputError(
          fmt::format("non-zero {} of a {} is not supported; optimize the "
                      "cameras in Metashape without it",
                      name, external_model.name));
  for (const char* name : {"fx", "fy", "skew"})
    if (keys.Has(name))
      throw InputError(
          fmt::format("'{}' is a format of PhotoScan before 1.2; export it "
                      "from a newer version",
                      name));
  if (keys.Has("corrections"))
    throw InputError(
        "'corrections' are not supported; optimize the cameras in Metashape "
        "without them");
}

// Converts the child elements of a calibration to a map. The image size may be
// in attributes.
CameraKeys MakeCalibrationKeys(const XmlElement& calibration,
                               const std::string& name) {
  YAML::Node map(YAML::NodeType::Map);
  for (const XmlElement& child : calibration.children) {
    if (calibration.Child(child.name) != &child)
      throw InputError(fmt::format("line {}: duplicate element '{}'",
                                   child.line, Printable(child.name)));
    if (child.name == "resolution") {
      for (const auto& [key, value] : child.attributes) map[key] = value;
      continue;
    }
    map[child.name] = child.text;
  }
  return CameraKeys(map, name);
}

ConvertedCamera ReadCalibration(const CameraKeys& keys,
                                const std::string& projection,
                                std::vector<std::string>* warnings) {
  ConvertedCamera lens;
  lens.external_model = &FindMetashapeModel(projection);
  RequireOnlyKnownKeys(keys, *lens.external_model);
  if (keys.Has("width") || keys.Has("height"))
    lens.size = {SidePx(keys["width"], "width"),
                 SidePx(keys["height"], "height")};
  const double f = RequiredNumber(keys, "f");
  lens.values = {f + ReadNumber(keys, "b1"), f, ReadNumber(keys, "cx"),
                 ReadNumber(keys, "cy")};
  lens.skew_px = ReadNumber(keys, "b2");
  for (const std::string& key : ListKeys(*lens.external_model))
    lens.values.push_back(ReadNumber(keys, key));
  keys.Skip({"projection", "date"});
  keys.Finish(*lens.external_model, warnings);
  return lens;
}

std::string GetAttribute(const XmlElement& element, const std::string& name) {
  const auto found = element.attributes.find(name);
  return found == element.attributes.end() ? "" : found->second;
}

// Returns the adjusted calibration of a sensor if there is one, otherwise the
// initial one.
const XmlElement* FindCalibration(const XmlElement& sensor) {
  const XmlElement* first = nullptr;
  for (const XmlElement& child : sensor.children) {
    if (child.name != kRoot) continue;
    if (GetAttribute(child, "class") == "adjusted") return &child;
    if (!first) first = &child;
  }
  return first;
}

// Reads the sensors of a document that Metashape's "Export Cameras" writes.
void ReadSensors(const XmlElement& root, ExchangeContents* contents) {
  std::vector<const XmlElement*> sensors;
  for (const XmlElement& chunk : root.children)
    if (const XmlElement* list = chunk.Child("sensors"))
      for (const XmlElement& sensor : list->children)
        if (sensor.name == "sensor") sensors.push_back(&sensor);
  for (const XmlElement* sensor : sensors) {
    const std::string label = GetAttribute(*sensor, "label"),
                      name = sensors.size() > 1
                                 ? "sensor" + GetAttribute(*sensor, "id")
                                 : "";
    const XmlElement* const calibration = FindCalibration(*sensor);
    if (!calibration) {
      contents->warnings.push_back(
          fmt::format("sensor '{}' has no calibration", Printable(label)));
      continue;
    }
    const std::string type = GetAttribute(*calibration, "type");
    InputCamera camera;
    camera.name = name;
    camera.lens =
        ReadCalibration(MakeCalibrationKeys(*calibration, name),
                        type.empty() ? GetAttribute(*sensor, "type") : type,
                        &contents->warnings);
    if (GetAttribute(*calibration, "class") == "initial")
      contents->warnings.push_back(fmt::format(
          "sensor '{}' has only its initial calibration", Printable(label)));
    contents->cameras.push_back(std::move(camera));
  }
  contents->warnings.push_back("camera poses are ignored");
}

ExchangeContents ReadMetashape(const ReadRequest& request) {
  const XmlElement root = ParseXml(request.text);
  ExchangeContents contents;
  if (root.name == kDocument) {
    ReadSensors(root, &contents);
    return contents;
  }
  if (root.name != kRoot)
    throw InputError(fmt::format("the root element is '{}', not '{}' or '{}'",
                                 Printable(root.name), kRoot, kDocument));
  const CameraKeys keys = MakeCalibrationKeys(root, "");
  contents.cameras.emplace_back().lens =
      ReadCalibration(keys, keys.Word("projection"), &contents.warnings);
  return contents;
}

bool IsMetashape(const std::string& text) {
  // Lensfun files also have <calibration> elements.
  return (text.find("<calibration>") != std::string::npos &&
          text.find("<distortion") == std::string::npos) ||
         (text.find("<document ") != std::string::npos &&
          text.find("<sensors") != std::string::npos);
}

// ---- Writing ---------------------------------------------------------------

std::string WriteMetashape(const WriteRequest& request) {
  const OutputCamera& camera = request.cameras.front();
  const ConvertedCamera& lens = camera.lens;
  std::string text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  if (camera.fit)
    text += fmt::format("<!-- Fitted {}: {} -->\n", lens.external_model->name,
                        FormatModelFit(*camera.fit));
  text += fmt::format("<{}>\n", kRoot);
  const auto add = [&](const std::string& name, const std::string& value) {
    text += fmt::format("  <{0}>{1}</{0}>\n", name, value);
  };
  const double fx = lens.Value("fx"), fy = lens.Value("fy");
  add("projection", lens.external_model->name);
  add("width", std::to_string(lens.size.width));
  add("height", std::to_string(lens.size.height));
  add("f", FormatReal(fy));
  add("cx", FormatReal(lens.Value("cx")));
  add("cy", FormatReal(lens.Value("cy")));
  add("b1", FormatReal(fx - fy));
  const std::vector<std::string> keys = ListKeys(*lens.external_model);
  const std::vector<double> coefficients = lens.ValuesFrom(4);
  for (size_t k = 0; k < keys.size(); ++k)
    add(keys[k], FormatReal(coefficients[k]));
  return text + fmt::format("</{}>\n", kRoot);
}

}  // namespace

Format MakeMetashapeFormat() {
  Format format;
  format.name = "metashape";
  format.holds =
      "Agisoft Metashape calibration .xml of a frame or fisheye camera; one "
      "file per camera of a rig";
  format.external_models = GetMetashapeModels();
  format.ending = ".xml";
  format.discards_rig_poses = true;
  format.recognizes = IsMetashape;
  format.read = ReadMetashape;
  format.write = WriteMetashape;
  return format;
}

}  // namespace raygrid
