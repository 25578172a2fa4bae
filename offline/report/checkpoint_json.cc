#include "report/checkpoint_json.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "dataset/content_hash.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/json_error.h"

namespace raygrid {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kVersion = 4;

// Returns a checksum over the checkpoint's inputs and contents, which together
// determine the result.
std::string Checksum(const std::string& inputs, const std::string& cameras) {
  ContentHash hash;
  hash.Add(inputs);
  hash.Add(cameras);
  return hash.Text();
}

constexpr char kBegin[] = "{\"raygrid_resume\":";
constexpr char kCameras[] = ",\"cameras\":", kEnd[] = "}\n";

// Returns the text of a checkpoint's cameras, after verifying its inputs and
// checksum, so that only files written by this program are parsed.
std::string FormatCameras(const std::string& text, const std::string& inputs) {
  constexpr size_t kMaxHeaderBytes = 4096;
  const size_t begin = text.rfind(kBegin, 0) == 0
                           ? text.substr(0, kMaxHeaderBytes).find(kCameras)
                           : std::string::npos;
  if (begin == std::string::npos)
    throw InputError("malformed: unexpected beginning");
  const Json head = Json::parse(text.substr(0, begin) + "}");
  if (head.at("raygrid_resume") != kVersion)
    throw InputError("unsupported version of resume.json");
  if (head.at("inputs") != inputs)
    throw InputError(
        "was written for other features, pattern or options, or by another "
        "version");
  const size_t first = begin + std::string(kCameras).size();
  const std::string end = kEnd;
  if (text.size() < first + end.size() ||
      text.compare(text.size() - end.size(), end.size(), end) != 0)
    throw InputError("malformed: truncated");
  std::string cameras = text.substr(first, text.size() - end.size() - first);
  if (head.at("checksum") != Checksum(inputs, cameras))
    throw InputError("was modified after it was written");
  return cameras;
}

Eigen::Vector2d ParsePixel(const Json& x, const Json& y) {
  return {x.get<double>(), y.get<double>()};
}

// ---- Features --------------------------------------------------------------

Json MakeFeaturesJson(const Dataset& dataset) {
  Json json = {{"width", dataset.image_size.width},
               {"height", dataset.image_size.height},
               {"images", Json::array()}};
  for (const ImageFeatures& image : dataset.images) {
    Json features = Json::array();
    for (const Feature& f : image.features)
      features.push_back({f.board, f.column, f.row, f.pixel.x(), f.pixel.y()});
    json["images"].push_back({{"image", image.image}, {"features", features}});
  }
  return json;
}

Dataset ParseFeatures(const Json& json) {
  Dataset dataset;
  dataset.image_size = {json.at("width"), json.at("height")};
  for (const Json& image : json.at("images")) {
    dataset.images.push_back({image.at("image"), {}});
    for (const Json& f : image.at("features"))
      dataset.images.back().features.push_back(
          {f.at(0), f.at(1), f.at(2), ParsePixel(f.at(3), f.at(4))});
  }
  return dataset;
}

// ---- Cross-validation ------------------------------------------------------

Json MakeResidualsJson(const std::vector<FeatureResidual>& residuals) {
  Json json = Json::array();
  for (const FeatureResidual& r : residuals)
    json.push_back({r.image, r.board, r.column, r.row, r.pixel.x(), r.pixel.y(),
                    r.error_px.x(), r.error_px.y()});
  return json;
}

std::vector<FeatureResidual> ParseResiduals(const Json& json) {
  std::vector<FeatureResidual> residuals;
  for (const Json& r : json)
    residuals.push_back({r.at(0), r.at(1), r.at(2), r.at(3),
                         ParsePixel(r.at(4), r.at(5)),
                         ParsePixel(r.at(6), r.at(7))});
  return residuals;
}

Json MakeTrialJson(const Trial& trial) {
  return {
      {"fold", trial.fold},
      {"cell_px", trial.knot_spacings_px.front()},
      {"rigid_boards", trial.rigid_boards},
      {"bodies", trial.has_rigid_targets},
      {"share_of_bends", trial.deformation_share},
      {"held_out", MakeResidualsJson(trial.held_out.alone.front())},
      {"flexed", MakeResidualsJson(trial.held_out.with_deformation.front())}};
}

Trial ParseTrial(const Json& json) {
  Trial trial = {
      json.at("fold"), {json.at("cell_px")}, json.at("rigid_boards"), {}};
  trial.has_rigid_targets = json.at("bodies");
  trial.deformation_share = json.at("share_of_bends");
  trial.held_out.alone = {ParseResiduals(json.at("held_out"))};
  trial.held_out.with_deformation = {ParseResiduals(json.at("flexed"))};
  return trial;
}

Checkpoint Parse(const Json& json) {
  Checkpoint checkpoint;
  if (json.contains("measured_again"))
    checkpoint.refined_features = ParseFeatures(json.at("measured_again"));
  for (const Json& trial : json.at("trials"))
    checkpoint.trials.push_back(ParseTrial(trial));
  return checkpoint;
}

Json MakeCheckpointJson(const Checkpoint& checkpoint) {
  Json json = {{"trials", Json::array()}};
  if (checkpoint.refined_features)
    json["measured_again"] = MakeFeaturesJson(*checkpoint.refined_features);
  for (const Trial& trial : checkpoint.trials)
    json["trials"].push_back(MakeTrialJson(trial));
  return json;
}

}  // namespace

std::string FormatCheckpoints(const std::vector<Checkpoint>& checkpoints,
                              const std::string& inputs) {
  Json cameras = Json::array();
  for (const Checkpoint& checkpoint : checkpoints)
    cameras.push_back(MakeCheckpointJson(checkpoint));
  const std::string text = cameras.dump();
  const Json head = {{"raygrid_resume", kVersion},
                     {"inputs", inputs},
                     {"checksum", Checksum(inputs, text)}};
  std::string all = head.dump();
  all.pop_back();  // the closing brace
  return all + kCameras + text + kEnd;
}

std::vector<Checkpoint> ReadCheckpoints(const std::string& path,
                                        const std::string& inputs) {
  if (!std::filesystem::exists(path))
    throw InputError(
        path +
        ": no such file, so there is nothing to resume; run without --resume");
  const std::string text = ReadFile(path);
  try {
    const Json cameras = Json::parse(FormatCameras(text, inputs));
    std::vector<Checkpoint> checkpoints;
    for (const Json& camera : cameras) checkpoints.push_back(Parse(camera));
    if (checkpoints.empty()) throw InputError("contains no camera");
    return checkpoints;
  } catch (const Json::exception& error) {
    throw InputError(path + ": malformed; run without --resume (" +
                     JsonProblem(error) + ")");
  } catch (const InputError& error) {
    throw InputError(path + ": " + error.what() + "; run without --resume");
  }
}

}  // namespace raygrid
