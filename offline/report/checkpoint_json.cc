#include "report/checkpoint_json.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "dataset/error.h"
#include "dataset/files.h"

namespace raygrid {
namespace {

using Json = nlohmann::ordered_json;

template <typename Vector>
Json VectorJson(const Vector& vector) {
  return std::vector<double>(vector.data(), vector.data() + vector.size());
}

template <typename Vector>
Vector ParseVector(const Json& json) {
  const auto values = json.get<std::vector<double>>();
  if (Vector::SizeAtCompileTime != Eigen::Dynamic &&
      static_cast<int>(values.size()) != Vector::SizeAtCompileTime)
    throw InputError("a vector has too many or too few numbers");
  return Eigen::Map<const Vector>(values.data(),
                                  static_cast<Eigen::Index>(values.size()));
}

Eigen::Vector2d ParsePixel(const Json& x, const Json& y) {
  return {x.get<double>(), y.get<double>()};
}

// ---- Features --------------------------------------------------------------

Json FeaturesJson(const Dataset& dataset) {
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

Json TrialJson(const Checkpoint::Trial& trial) {
  Json residuals = Json::array();
  for (const FeatureResidual& r : trial.held_out)
    residuals.push_back({r.image, r.board, r.column, r.row, r.pixel.x(),
                         r.pixel.y(), r.error_px.x(), r.error_px.y()});
  return {{"fold", trial.fold},
          {"cell_px", trial.cell_px},
          {"held_out", residuals}};
}

Checkpoint::Trial ParseTrial(const Json& json) {
  Checkpoint::Trial trial = {json.at("fold"), json.at("cell_px"), {}};
  for (const Json& r : json.at("held_out"))
    trial.held_out.push_back({r.at(0), r.at(1), r.at(2), r.at(3),
                              ParsePixel(r.at(4), r.at(5)),
                              ParsePixel(r.at(6), r.at(7))});
  return trial;
}

// ---- Adjustment ------------------------------------------------------------

Json AdjustmentJson(const Checkpoint::Adjustment& adjustment) {
  Json json = {{"camera", VectorJson(adjustment.camera)},
               {"prior_weights", adjustment.prior_weights},
               {"points_weight", adjustment.points_weight},
               {"poses", Json::array()},
               {"points", Json::array()}};
  for (const Pose& pose : adjustment.poses)
    json["poses"].push_back(
        {VectorJson(pose.rotation.coeffs()), VectorJson(pose.translation)});
  for (const Eigen::Vector3d& point : adjustment.points)
    json["points"].push_back(VectorJson(point));
  return json;
}

Checkpoint::Adjustment ParseAdjustment(const Json& json) {
  Checkpoint::Adjustment adjustment;
  adjustment.camera = ParseVector<Eigen::VectorXd>(json.at("camera"));
  adjustment.prior_weights =
      json.at("prior_weights").get<std::vector<double>>();
  adjustment.points_weight = json.at("points_weight");
  for (const Json& pose : json.at("poses"))
    adjustment.poses.push_back(
        {Eigen::Quaterniond(ParseVector<Eigen::Vector4d>(pose.at(0))),
         ParseVector<Eigen::Vector3d>(pose.at(1))});
  for (const Json& point : json.at("points"))
    adjustment.points.push_back(ParseVector<Eigen::Vector3d>(point));
  return adjustment;
}

Checkpoint Parse(const Json& json) {
  Checkpoint checkpoint;
  if (json.contains("measured_again"))
    checkpoint.measured_again = ParseFeatures(json.at("measured_again"));
  for (const Json& trial : json.at("trials"))
    checkpoint.trials.push_back(ParseTrial(trial));
  if (json.contains("adjustment"))
    checkpoint.adjustment = ParseAdjustment(json.at("adjustment"));
  return checkpoint;
}

Json CheckpointJson(const Checkpoint& checkpoint) {
  Json json = {{"trials", Json::array()}};
  if (checkpoint.measured_again)
    json["measured_again"] = FeaturesJson(*checkpoint.measured_again);
  for (const Checkpoint::Trial& trial : checkpoint.trials)
    json["trials"].push_back(TrialJson(trial));
  if (checkpoint.adjustment)
    json["adjustment"] = AdjustmentJson(*checkpoint.adjustment);
  return json;
}

}  // namespace

std::string FormatCheckpoints(const std::vector<Checkpoint>& checkpoints,
                              const std::string& inputs) {
  Json json = {
      {"raygrid_resume", 2}, {"inputs", inputs}, {"cameras", Json::array()}};
  for (const Checkpoint& checkpoint : checkpoints)
    json["cameras"].push_back(CheckpointJson(checkpoint));
  return json.dump() + "\n";
}

std::vector<Checkpoint> ReadCheckpoints(const std::string& path,
                                        const std::string& inputs) {
  if (!std::filesystem::exists(path))
    throw InputError(path +
                     ": no such file, so no interrupted calibration to go on "
                     "from; run without --resume");
  const std::string text = ReadFile(path);
  try {
    const Json json = Json::parse(text);
    if (json.at("raygrid_resume") != 2)
      throw InputError("unknown version of resume.json");
    if (json.at("inputs") != inputs)
      throw InputError("is of other features, pattern or options");
    std::vector<Checkpoint> checkpoints;
    for (const Json& camera : json.at("cameras"))
      checkpoints.push_back(Parse(camera));
    if (checkpoints.empty()) throw InputError("holds no camera");
    return checkpoints;
  } catch (const Json::exception& error) {
    throw InputError(path + ": malformed; run without --resume (" +
                     error.what() + ")");
  } catch (const InputError& error) {
    throw InputError(path + ": " + error.what() + "; run without --resume");
  }
}

}  // namespace raygrid
