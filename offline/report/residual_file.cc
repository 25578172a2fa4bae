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

std::vector<FeatureResidual>* SelectSet(const std::string& name,
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
  const std::string text = ReadFile(path);
  CsvReader table(
      path, text,
      {"set", "image", "board", "column", "row", "x", "y", "dx", "dy"});
  table.LimitRows(kMaxResidualRows);
  const bool has_camera = table.HasColumn("camera");
  std::map<std::string, ResidualSets> cameras;
  while (table.Next()) {
    ResidualSets& sets = cameras[has_camera ? table.Text("camera") : ""];
    std::vector<FeatureResidual>* set = SelectSet(table.Text("set"), &sets);
    if (!set)
      throw InputError(fmt::format(
          "{}: unknown value '{}' in column 'set'; rerun the calibration",
          table.Place(), table.Text("set")));
    set->push_back({table.Text("image"),
                    table.Integer("board"),
                    table.Integer("column"),
                    table.Integer("row"),
                    {table.Number("x"), table.Number("y")},
                    {table.Number("dx"), table.Number("dy")}});
  }
  return cameras;
}

}  // namespace raygrid
