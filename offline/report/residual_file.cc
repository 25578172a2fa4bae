#include "report/residual_file.h"

#include <fmt/format.h>

#include <iterator>

#include "dataset/csv.h"
#include "dataset/error.h"
#include "dataset/files.h"

namespace raygrid {
namespace {

constexpr char kHeader[] = "set,image,board,column,row,x,y,dx,dy\n";

void AddLines(const std::string& prefix, const char* set,
              const std::vector<FeatureResidual>& residuals,
              std::string* text) {
  for (const FeatureResidual& r : residuals)
    fmt::format_to(std::back_inserter(*text),
                   "{}{},{},{},{},{},{:.4f},{:.4f},{:.5f},{:.5f}\n", prefix,
                   set, CsvField(r.image), r.board, r.column, r.row,
                   r.pixel.x(), r.pixel.y(), r.error_px.x(), r.error_px.y());
}

void AddLines(const std::string& prefix, const CalibrationResult& result,
              std::string* text) {
  AddLines(prefix, "training", result.training, text);
  AddLines(prefix, "held-out", result.held_out, text);
  AddLines(prefix, "rejected", result.rejected_features, text);
}

std::vector<FeatureResidual>* FindSet(const std::string& name,
                                      ResidualSets* sets) {
  if (name == "training") return &sets->training;
  if (name == "held-out") return &sets->held_out;
  if (name == "rejected") return &sets->rejected;
  if (name == "held-out-in-rig") return &sets->held_out_in_rig;
  return nullptr;
}

}  // namespace

std::string FormatResiduals(const RigResult& result) {
  std::string text = result.IsRig() ? "camera," : "";
  text += kHeader;
  for (size_t c = 0; c < result.cameras.size(); ++c) {
    const std::string prefix =
        result.IsRig() ? CsvField(result.cameras[c].camera.name) + "," : "";
    AddLines(prefix, result.cameras[c], &text);
    if (c < result.held_out.size())
      AddLines(prefix, "held-out-in-rig", result.held_out[c], &text);
  }
  return text;
}

std::map<std::string, ResidualSets> ReadResiduals(const std::string& path) {
  const CsvTable table(
      path, ReadFile(path),
      {"set", "image", "board", "column", "row", "x", "y", "dx", "dy"});
  const bool has_camera = table.HasColumn("camera");
  std::map<std::string, ResidualSets> cameras;
  for (size_t i = 0; i < table.num_rows(); ++i) {
    ResidualSets& sets = cameras[has_camera ? table.Text(i, "camera") : ""];
    std::vector<FeatureResidual>* set = FindSet(table.Text(i, "set"), &sets);
    if (!set)
      throw InputError(fmt::format("{}: unknown set '{}'; calibrate again",
                                   table.Place(i), table.Text(i, "set")));
    set->push_back({table.Text(i, "image"),
                    table.Integer(i, "board"),
                    table.Integer(i, "column"),
                    table.Integer(i, "row"),
                    {table.Number(i, "x"), table.Number(i, "y")},
                    {table.Number(i, "dx"), table.Number(i, "dy")}});
  }
  return cameras;
}

}  // namespace raygrid
