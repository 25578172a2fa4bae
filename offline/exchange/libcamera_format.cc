#include "exchange/libcamera_format.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "dataset/yaml_file.h"
#include "exchange/opencv_forms.h"
#include "exchange/own_json.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

constexpr char kTuningModules[] = "modules";
constexpr char kTuningDewarp[] = "Dewarp";
constexpr char kTuningMatrix[] = "cm";
constexpr char kTuningCoefficients[] = "coefficients";
constexpr char kTuningSize[] = "image_size";  // in raygrid's own map

const std::vector<LensForm>& LibcameraForms() {
  static const std::vector<LensForm> forms = {
      OpenCvForm("dewarp4", 4), OpenCvForm("dewarp5", 5),
      OpenCvForm("dewarp8", 8), OpenCvForm("dewarp12", 12)};
  return forms;
}

// ---- Reading ---------------------------------------------------------------

YAML::Node DewarpNode(const YAML::Node& root) {
  const YAML::Node modules = root.IsMap() ? root[kTuningModules] : YAML::Node();
  if (modules && modules.IsSequence())
    for (const YAML::Node& module : modules)
      if (module.IsMap() && module[kTuningDewarp]) return module[kTuningDewarp];
  throw InputError(fmt::format("{}: there is no module '{}'", kTuningModules,
                               kTuningDewarp));
}

LensInForm ReadDewarp(const YAML::Node& dewarp) {
  if (!dewarp.IsMap())
    throw InputError(fmt::format("{}: no map", kTuningDewarp));
  const std::vector<double> k =
      FiniteNumbers(dewarp[kTuningMatrix], kTuningMatrix, 9);
  if (k[1] != 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1)
    throw InputError(fmt::format("{}: has numbers besides fx, fy, cx, cy and 1",
                                 kTuningMatrix));
  const std::vector<double> coefficients =
      FiniteNumbers(dewarp[kTuningCoefficients], kTuningCoefficients);
  LensInForm lens;
  for (const LensForm& form : LibcameraForms())
    if (form.parameters.size() == 4 + coefficients.size()) lens.form = &form;
  if (!lens.form)
    throw InputError(
        fmt::format("{}: {} numbers; libcamera takes 4, 5, 8 and "
                    "12",
                    kTuningCoefficients, coefficients.size()));
  lens.values = {k[0], k[4], k[2], k[5]};
  lens.values.insert(lens.values.end(), coefficients.begin(),
                     coefficients.end());
  return lens;
}

ExchangeContents ReadLibcamera(const ReadRequest& request) {
  RequireYamlFile(request.path, request.text);
  const YAML::Node root = YAML::Load(request.text);
  if (!request.form.empty())
    throw InputError(
        "the number of coefficients says the model; leave --model out");
  ReadLens camera;
  camera.lens = ReadDewarp(DewarpNode(root));
  const YAML::Node own = root[kOwnKey];
  TakeOwnJson(own, &camera);
  if (request.size)
    camera.lens.size = *request.size;
  else if (own && own.IsMap() && own[kTuningSize])
    camera.lens.size = SizeOfList(own[kTuningSize], kTuningSize);
  else
    throw InputError(
        "a tuning file does not say how large images are; add --image-size");
  ExchangeContents contents;
  contents.cameras.push_back(std::move(camera));
  return contents;
}

bool IsLibcamera(const std::string& text) {
  for (const char* word : {"modules:", "Dewarp:", "coefficients:"})
    if (text.find(word) == std::string::npos) return false;
  return true;
}

// ---- Writing ---------------------------------------------------------------

// libcamera passes over keys that it does not know.
std::string WriteLibcamera(const WriteRequest& request) {
  const WrittenLens& camera = request.cameras.front();
  const LensInForm& lens = camera.lens;
  std::string own = fmt::format("  {}: [{}, {}]\n", kTuningSize,
                                lens.size.width, lens.size.height);
  if (!camera.name.empty()) own += "  name: " + QuotedYaml(camera.name) + "\n";
  if (!camera.serial.empty())
    own += "  serial: " + QuotedYaml(camera.serial) + "\n";
  if (camera.fit)
    own += "  fit: " + QuotedYaml(LensFitText(*camera.fit)) + "\n";
  return fmt::format(
      "%YAML 1.1\n---\nversion: 1\nmodules:\n  - Dewarp:\n      cm: [\n"
      "        {},\n        {},\n        {},\n      ]\n      coefficients: [\n"
      "        {},\n      ]\n{}:\n{}...\n",
      RealTexts({lens.Value("fx"), 0, lens.Value("cx")}),
      RealTexts({0, lens.Value("fy"), lens.Value("cy")}), RealTexts({0, 0, 1}),
      RealTexts(lens.ValuesFrom(4)), kOwnKey, own);
}

}  // namespace

Format LibcameraFormat() {
  Format format;
  format.name = "libcamera";
  format.holds =
      "libcamera's tuning file of the i.MX 8M Plus: the lens of the module "
      "Dewarp";
  format.forms = LibcameraForms();
  format.drops_rigs = true;
  format.recognizes = IsLibcamera;
  format.read = ReadLibcamera;
  format.write = WriteLibcamera;
  return format;
}

}  // namespace raygrid
