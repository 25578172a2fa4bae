#include "exchange/libcamera_format.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "exchange/camera_keys.h"
#include "exchange/opencv_model_list.h"
#include "exchange/raygrid_json.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

constexpr char kTuningModules[] = "modules";
constexpr char kTuningDewarp[] = "Dewarp";
constexpr char kTuningMatrix[] = "cm";
constexpr char kTuningCoefficients[] = "coefficients";
constexpr char kTuningSize[] = "image_size";  // key added by raygrid

const std::vector<ExternalModel>& GetLibcameraModels() {
  static const std::vector<ExternalModel> external_models = {
      MakeOpenCvModel("dewarp4", 4), MakeOpenCvModel("dewarp5", 5),
      MakeOpenCvModel("dewarp8", 8), MakeOpenCvModel("dewarp12", 12)};
  return external_models;
}

// ---- Reading ---------------------------------------------------------------

YAML::Node MakeDewarpNode(const YAML::Node& root) {
  const YAML::Node modules = root.IsMap() ? root[kTuningModules] : YAML::Node();
  if (modules && modules.IsSequence())
    for (const YAML::Node& module : modules)
      if (module.IsMap() && module[kTuningDewarp]) return module[kTuningDewarp];
  throw InputError(
      fmt::format("{}: missing module '{}'", kTuningModules, kTuningDewarp));
}

ConvertedCamera ReadDewarp(const CameraKeys& dewarp,
                           std::vector<std::string>* warnings) {
  ConvertedCamera lens;
  ReadCameraMatrix(FiniteNumbers(dewarp[kTuningMatrix], kTuningMatrix, 9),
                   kTuningMatrix, &lens);
  const std::vector<double> coefficients =
      FiniteNumbers(dewarp[kTuningCoefficients], kTuningCoefficients);
  for (const ExternalModel& external_model : GetLibcameraModels())
    if (external_model.parameters.size() == 4 + coefficients.size())
      lens.external_model = &external_model;
  if (!lens.external_model)
    throw InputError(
        fmt::format("{}: {} coefficients; libcamera supports 4, 5, 8 and 12",
                    kTuningCoefficients, coefficients.size()));
  lens.values.insert(lens.values.end(), coefficients.begin(),
                     coefficients.end());
  dewarp.Finish(*lens.external_model, warnings);
  return lens;
}

ExchangeContents ReadLibcamera(const ReadRequest& request) {
  const YAML::Node root = LoadForeignMap(request.path, request.text);
  ExchangeContents contents;
  InputCamera camera;
  camera.lens = ReadDewarp(CameraKeys(MakeDewarpNode(root), kTuningDewarp),
                           &contents.warnings);
  const YAML::Node own = root[kRaygridKey];
  ParseRaygridJson(own, &camera);
  if (own && own.IsMap() && own[kTuningSize])
    camera.lens.size = GetListSize(own[kTuningSize], kTuningSize);
  contents.cameras.push_back(std::move(camera));
  return contents;
}

bool IsLibcamera(const std::string& text) {
  for (const char* word : {"modules:", "Dewarp:", "coefficients:"})
    if (text.find(word) == std::string::npos) return false;
  return true;
}

// ---- Writing ---------------------------------------------------------------

// raygrid's additional keys are harmless: libcamera ignores unknown keys.
std::string WriteLibcamera(const WriteRequest& request) {
  const OutputCamera& camera = request.cameras.front();
  const ConvertedCamera& lens = camera.lens;
  std::string own = fmt::format("  {}: [{}, {}]\n", kTuningSize,
                                lens.size.width, lens.size.height);
  if (!camera.name.empty()) own += "  name: " + QuotedYaml(camera.name) + "\n";
  if (!camera.serial.empty())
    own += "  serial: " + QuotedYaml(camera.serial) + "\n";
  if (camera.fit)
    own += "  fit: " + QuotedYaml(FormatModelFit(*camera.fit)) + "\n";
  return fmt::format(
      "%YAML 1.1\n---\nversion: 1\nmodules:\n  - Dewarp:\n      cm: [\n"
      "        {},\n        {},\n        {},\n      ]\n      coefficients: [\n"
      "        {},\n      ]\n{}:\n{}...\n",
      RealTexts({lens.Value("fx"), 0, lens.Value("cx")}),
      RealTexts({0, lens.Value("fy"), lens.Value("cy")}), RealTexts({0, 0, 1}),
      RealTexts(lens.ValuesFrom(4)), kRaygridKey, own);
}

}  // namespace

Format MakeLibcameraFormat() {
  Format format;
  format.name = "libcamera";
  format.holds =
      "libcamera tuning file of the i.MX 8M Plus: intrinsics of the Dewarp "
      "module";
  format.external_models = GetLibcameraModels();
  format.discards_rig_poses = true;
  format.recognizes = IsLibcamera;
  format.read = ReadLibcamera;
  format.write = WriteLibcamera;
  return format;
}

}  // namespace raygrid
