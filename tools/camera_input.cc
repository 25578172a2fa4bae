#include "camera_input.h"

#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "camera/camera_frame.h"
#include "camera/turned_camera.h"
#include "dataset/csv.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/text_encoding.h"

namespace raygrid {

CameraInput ReadCamera(const std::string& path) {
  const std::string bytes = ReadFile(path);
  CameraInput input;
  if (!IsBlob(path, bytes)) {
    input.file = ReadCameraFile(path);
    return input;
  }
  input.blob.emplace(path, bytes);
  input.file.camera = input.blob->ToModel();
  rg_camera_section identity;
  rg_blob_camera(&input.blob->blob(), &identity);
  // The format asks for UTF-8, and readers do not check it.
  input.file.name = Printable(identity.name);
  input.file.serial = Printable(identity.serial);
  return input;
}

std::optional<Eigen::Quaterniond> TurnIntoCameraFrame(CameraFile* file) {
  const CameraFrame frame = FindCameraFrame(*file->camera);
  if (frame.AngleRad() <= kMaxFrameTurnRad) return std::nullopt;
  if (file->camera->IsCentral())
    file->camera =
        std::make_unique<TurnedCamera>(*file->camera, frame.frame_from_camera);
  else
    file->camera = Turned(*file->camera, frame.frame_from_camera);
  return frame.frame_from_camera;
}

ImageSize ParseImageSize(const std::string& option, const std::string& text) {
  ImageSize size;
  char end;
  if (std::sscanf(text.c_str(), "%dx%d%c", &size.width, &size.height, &end) !=
          2 ||
      size.width < 1 || size.height < 1)
    throw Error(
        ExitCode::kUsage,
        fmt::format("{} {}: expected WIDTHxHEIGHT, as 640x480", option, text));
  return size;
}

void PrintOrWrite(const std::string& path, const std::string& text) {
  if (!path.empty())
    WriteFile(path, text);
  else if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() ||
           std::fflush(stdout) != 0)
    throw Error(ExitCode::kOutput, "standard output cannot be written");
}

std::string CsvAsJson(const std::string& csv,
                      const std::vector<std::string>& columns) {
  const CsvTable table("result", csv, columns);
  auto rows = nlohmann::ordered_json::array();
  for (size_t i = 0; i < table.num_rows(); ++i) {
    nlohmann::ordered_json row;
    for (const std::string& column : columns) {
      if (table.Text(i, column).empty())
        row[column] = nullptr;
      else
        row[column] = table.Number(i, column);
    }
    rows.push_back(std::move(row));
  }
  return rows.dump(2) + "\n";
}

}  // namespace raygrid
