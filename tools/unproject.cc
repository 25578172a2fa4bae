#include <fmt/format.h>

#include <memory>

#include "camera_input.h"
#include "commands.h"
#include "dataset/csv.h"
#include "dataset/files.h"

namespace raygrid {
namespace {

struct Arguments {
  std::string camera, pixels, output;
};

void Run(const Arguments& arguments) {
  const CameraInput input = ReadCamera(arguments.camera);
  const CsvTable table(arguments.pixels, ReadFile(arguments.pixels),
                       {"x", "y"});
  std::string text = "x,y,dx,dy,dz\n";
  for (size_t i = 0; i < table.num_rows(); ++i) {
    const Eigen::Vector2d pixel(table.Number(i, "x"), table.Number(i, "y"));
    const auto ray = input.blob ? input.blob->Unproject(pixel)
                                : input.file.camera->Unproject(pixel);
    text += fmt::format("{},{},", table.Text(i, "x"), table.Text(i, "y"));
    text += ray ? fmt::format("{:.12f},{:.12f},{:.12f}\n", ray->x(), ray->y(),
                              ray->z())
                : std::string(",,\n");
  }
  PrintOrWrite(arguments.output, text);
}

}  // namespace

void AddUnproject(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "unproject",
      "Directions that pixels look along: x,y to x,y,dx,dy,dz; empty fields "
      "outside the calibrated area. A blob is evaluated by the fixed-point "
      "runtime, a camera.yaml in double precision.",
      "raygrid unproject camera.raygrid --pixels px.csv -o rays.csv", common);
  auto arguments = std::make_shared<Arguments>();
  command->add_option("camera", arguments->camera, "camera.yaml or a blob")
      ->required();
  command->add_option("--pixels", arguments->pixels, "CSV with x,y")
      ->required();
  command->add_option("-o,--output", arguments->output,
                      "CSV to write (default: print)");
  command->callback([arguments] { Run(*arguments); });
}

}  // namespace raygrid
