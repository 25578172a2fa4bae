#include "exchange/opencv_models.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "exchange/opencv_model_list.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace opencv_file {

namespace {

// OpenCV's omnidir model: k1, k2, p1, p2, and xi, which has a separate key.
ExternalModel MakeOmnidirModel() {
  ExternalModel external_model = MakeExternalModel(
      kOmnidir, models::kOmniRadtan, {"k1", "k2", "p1", "p2", "xi"});
  external_model.export_only_if_named = true;
  return external_model;
}

}  // namespace

const std::vector<ExternalModel>& GetOpenCvModels() {
  static const std::vector<ExternalModel> external_models = {
      MakeOpenCvModel("opencv4", 4),
      MakeOpenCvModel("opencv5", 5),
      MakeOpenCvModel("opencv8", 8),
      MakeOpenCvModel("opencv12", 12),
      MakeOpenCvModel("opencv14", 14),
      MakeOpenCvFisheyeModel(kFisheye),
      MakeOmnidirModel()};
  return external_models;
}

namespace {

const ExternalModel& FindOpenCvModel(const std::string& name) {
  for (const ExternalModel& external_model : GetOpenCvModels())
    if (external_model.name == name) return external_model;
  throw InputError(
      fmt::format("unknown distortion model '{}'; supported are opencv4, "
                  "opencv5, opencv8, opencv12, opencv14, fisheye and omnidir",
                  Printable(name)));
}

// Returns the pinhole model with a number of coefficients.
const ExternalModel& FindModelByCount(size_t count) {
  const std::map<size_t, const char*> names = {
      {0, "opencv4"}, {4, "opencv4"},   {5, "opencv5"},
      {8, "opencv8"}, {12, "opencv12"}, {14, "opencv14"}};
  const auto name = names.find(count);
  if (name == names.end())
    throw InputError(fmt::format(
        "{} distortion coefficients, expected 4, 5, 8, 12 or 14", count));
  return FindOpenCvModel(name->second);
}

// The camera model that a file states, and the key that states it.
struct StatedModel {
  ModelFamily family = ModelFamily::kPinhole;
  std::string key, word;
};

std::optional<StatedModel> FindStatedModel(const CameraKeys& keys,
                                           const Affixes& affixes) {
  std::optional<StatedModel> said;
  const auto say = [&](ModelFamily family, const std::string& key) {
    // "pinhole" combined with a fisheye distortion model is a fisheye camera.
    const bool is_vague = said && said->word == "pinhole";
    if (said && !is_vague && said->family != family &&
        keys.Word(key) != "pinhole")
      throw InputError(fmt::format("'{}' indicates {}, but '{}' indicates {}",
                                   said->key, ToString(said->family), key,
                                   ToString(family)));
    if (!said || is_vague) said = StatedModel{family, key, keys.Word(key)};
  };
  const std::string xi = affixes.prefix + "xi" + affixes.suffix;
  // xi = 0 is a pinhole camera of programs that support both models.
  if (keys.Has(xi) && AllNumbers(keys[xi], xi) != std::vector<double>{0})
    say(ModelFamily::kOmni, xi);
  for (const std::string& key : kFisheyeKeys) {
    const std::string word = Lowercase(keys.Word(key));
    if (word == "1" || word == "true" || word == "yes")
      say(ModelFamily::kFisheye, key);
    else if (word == "0" || word == "false" || word == "no")
      say(ModelFamily::kPinhole, key);
    else
      continue;
    keys.Skip({key});
  }
  for (const std::string& key : kModelKeys) {
    const auto family = ParseModelFamily(keys.Word(key));
    if (!family) continue;
    say(*family, key);
    keys.Skip({key});
  }
  return said;
}

}  // namespace

const ExternalModel& DetermineModel(const CameraKeys& keys,
                                    const Affixes& affixes,
                                    const ReadRequest& request, double skew_px,
                                    DistortionCoefficients* coefficients,
                                    std::vector<std::string>* warnings) {
  std::vector<double>& d = coefficients->numbers;
  const auto said = FindStatedModel(keys, affixes);
  bool is_fisheye = said && said->family == ModelFamily::kFisheye;
  // RealSense states an inverse distortion model even if all coefficients are
  // 0.
  const bool are_all_zero = std::all_of(
      d.begin(), d.end(), [](double number) { return number == 0; });
  if (said && said->family == ModelFamily::kOther && !are_all_zero)
    throw InputError(fmt::format(
        "'{}' is {}, but only pinhole, fisheye and omnidir are supported",
        said->key, Printable(said->word)));
  if (said && said->family == ModelFamily::kOmni) {
    if (!keys.Has(affixes.prefix + "xi" + affixes.suffix))
      throw InputError("missing 'xi' of the omnidirectional camera");
    return FindOpenCvModel(kOmnidir);
  }
  const ExternalModel* const wanted =
      request.external_model.empty() ? nullptr
                                     : &FindOpenCvModel(request.external_model);
  if (said && wanted && (wanted->name == kFisheye) != is_fisheye)
    throw InputError(
        fmt::format("--model {}: contradicts the file, which specifies '{}: "
                    "{}'; omit the option",
                    request.external_model, said->key, Printable(said->word)));
  if (wanted && wanted->name != kFisheye) {
    TrimCoefficients(wanted->parameters.size() - 4, &d);
    if (d.size() + 4 != wanted->parameters.size())
      throw InputError(
          fmt::format("--model {}: the file has {} distortion coefficients; "
                      "omit the option",
                      request.external_model, d.size()));
  }
  is_fisheye = is_fisheye || (wanted && wanted->name == kFisheye);
  if (coefficients->has_fisheye_names && !is_fisheye && (said || wanted))
    throw InputError(fmt::format(
        "k1 to k4 without p1 and p2 are interpreted as cv::fisheye, but {} "
        "indicates a pinhole camera; if it is one, add p1 and p2",
        said ? "'" + said->key + "'" : "--model " + request.external_model));
  if (!said && !wanted && d.size() == 4) {
    const bool is_named = coefficients->has_fisheye_names;
    is_fisheye = is_named || coefficients->is_fisheye_column || skew_px != 0;
    warnings->push_back(
        is_named
            ? "assuming k1, k2, k3, k4 of cv::fisheye, because of their names"
        : is_fisheye
            ? "assuming k1, k2, k3, k4 of cv::fisheye, because of the column "
              "vector or the skew; for a pinhole camera use --model opencv4"
            : "assuming k1, k2, p1, p2 of a pinhole camera; for cv::fisheye "
              "use --model fisheye");
  }
  if (is_fisheye) {
    TrimCoefficients(4, &d);
    if (d.empty()) d.assign(4, 0);
    return FindOpenCvModel(kFisheye);
  }
  // Removes trailing zeros: 12 or 14 coefficients may be equivalent to 8.
  if (d.size() > 8) TrimCoefficients(8, &d);
  if (d.size() > 5 && d.size() < 8) TrimCoefficients(5, &d);
  const ExternalModel& external_model = FindModelByCount(d.size());
  if (d.empty()) d.assign(4, 0);
  return external_model;
}

}  // namespace opencv_file
}  // namespace raygrid
