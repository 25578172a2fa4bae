#include "camera_input.h"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "bag_input.h"
#include "dataset/csv.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/fixed_operating_point.h"
#include "dataset/text_encoding.h"
#include "exchange/format.h"
#include "exchange/table_format.h"

namespace raygrid {
namespace {

CameraFile ParseForeignCamera(const Format& format, const std::string& path,
                              const std::string& text) {
  RequireCameraFormat(format, path);
  const ExchangeContents contents =
      ReadExchangeFile(&format, {path, text, "", std::nullopt});
  RequireCameras(contents, path);
  if (contents.cameras.size() != 1)
    throw InputError(
        fmt::format("{}: contains {} cameras; use 'raygrid import' to write "
                    "one file per camera",
                    path, contents.cameras.size()));
  for (const std::string& warning : contents.warnings)
    fmt::print(stderr, "raygrid: {}: {}\n", Printable(path), warning);
  return MakeCameraFile(contents.cameras.front());
}

// Prints on standard error the conditions for which the centre of the range is
// used.
void NoteReferencePoint(const std::string& path,
                        const std::vector<OperatingRange>& ranges) {
  fmt::print(stderr,
             "raygrid: {}: calibrated over {}; using the centre of the range "
             "(select another operating point with --at)\n",
             Printable(path), ToString(ranges));
}

// How an operating-point model is read.
enum class OperatingPointUse {
  kSingleCamera,    // one camera, at the given operating point
  kRemainingModel,  // a model over the conditions without given values
  kEitherCamera,    // one camera of a pair; ignores values for the other one
};

// Returns the values for a camera with these ranges, checked against each
// range.
FixedOperatingPoint ValuesFor(const std::string& path,
                              const RequestedOperatingPoint& at,
                              OperatingPointUse use,
                              const std::vector<OperatingRange>& ranges) {
  if (use != OperatingPointUse::kEitherCamera)
    return FixRequestedPointInRange(at, ranges, path);
  return FixRequestedPointInRange(FilterByRanges(at, ranges), ranges, path);
}

// Replaces the reference camera of an operating-point model by the camera at
// the requested operating point. Returns the model's ranges.
std::vector<OperatingRange> SelectOperatingPoint(
    const std::string& path, const RequestedOperatingPoint& at,
    OperatingPointUse use, CameraFile* file) {
  if (!file->stack) return {};
  const std::vector<OperatingRange> ranges = file->stack->cameras.ranges();
  if (at.HasValues())
    *file = MakeCameraFileAt(*file, ValuesFor(path, at, use, ranges));
  if (file->stack && use != OperatingPointUse::kRemainingModel)
    NoteReferencePoint(path, file->stack->cameras.ranges());
  return ranges;
}

Error NoOperatingPointModel(const std::string& path) {
  return Error(ExitCode::kUsage,
               path +
                   ": --at: the camera was not calibrated over a range of "
                   "focus or temperature; omit the option");
}

CameraInput ParseAnyCamera(const std::string& path, const std::string& bytes,
                           const RequestedOperatingPoint& at,
                           OperatingPointUse use) {
  CameraInput input;
  if (!IsBlob(path, bytes)) {
    if (const TableFormat* table = RecognizeTable(bytes))
      throw InputError(
          fmt::format("{}: {}", path, table->ExplainMissingCamera()));
    const Format* format = RecognizeCamera(path, bytes);
    input.file = format ? ParseForeignCamera(*format, path, bytes)
                        : ParseCameraFile(path, bytes);
    input.ranges = SelectOperatingPoint(path, at, use, &input.file);
    return input;
  }
  input.blob.emplace(path, bytes);
  if (const auto range = input.blob->Range()) {
    input.ranges = {*range};
    const FixedOperatingPoint held =
        at.HasValues() ? ValuesFor(path, at, use, input.ranges)
                       : FixedOperatingPoint(1);
    if (held[0])
      input.blob->SetOperatingPoint(*held[0]);
    else if (use != OperatingPointUse::kRemainingModel)
      NoteReferencePoint(path, input.ranges);
  }
  input.file.camera = input.blob->ToModel();
  rg_camera_section identity;
  rg_blob_camera(&input.blob->blob(), &identity);
  // The format requires UTF-8, but readers do not check it.
  input.file.name = Printable(identity.name);
  input.file.serial = Printable(identity.serial);
  input.file.capture = input.blob->GetCalibrationCapture();
  input.file.line_delay = input.blob->GetRowTime();
  return input;
}

}  // namespace

CameraInput ReadCamera(const std::string& path,
                       const RequestedOperatingPoint& at) {
  return ParseCamera(path, ReadCameraBytes(path), at);
}

CameraInput ParseCamera(const std::string& path, const std::string& bytes,
                        const RequestedOperatingPoint& at) {
  CameraInput input =
      ParseAnyCamera(path, bytes, at, OperatingPointUse::kSingleCamera);
  if (at.HasValues() && input.ranges.empty()) throw NoOperatingPointModel(path);
  return input;
}

CameraInput ReadCameraOrModel(const std::string& path,
                              const RequestedOperatingPoint& at) {
  CameraInput input = ParseAnyCamera(path, ReadCameraBytes(path), at,
                                     OperatingPointUse::kRemainingModel);
  if (at.HasValues() && input.ranges.empty()) throw NoOperatingPointModel(path);
  return input;
}

std::array<CameraInput, 2> ReadCameraPair(const std::string& first,
                                          const std::string& second,
                                          const RequestedOperatingPoint& at) {
  std::array<CameraInput, 2> cameras = {
      ParseAnyCamera(first, ReadCameraBytes(first), at,
                     OperatingPointUse::kEitherCamera),
      ParseAnyCamera(second, ReadCameraBytes(second), at,
                     OperatingPointUse::kEitherCamera)};
  std::vector<OperatingRange> ranges = cameras[0].ranges;
  ranges.insert(ranges.end(), cameras[1].ranges.begin(),
                cameras[1].ranges.end());
  if (at.HasValues() && ranges.empty())
    throw NoOperatingPointModel(first + ", " + second);
  if (FilterByRanges(at, ranges).named.size() < at.named.size())
    throw Error(ExitCode::kUsage,
                fmt::format("{}, {}: {}: both cameras were calibrated over {} "
                            "only; omit the other value",
                            first, second, at.Text(),
                            OperatingParameterName(ranges[0].condition)));
  for (size_t c = 0; c < 2; ++c) {
    const std::vector<OperatingRange>& own = cameras[c].ranges;
    if (own.empty() || FilterByRanges(at, own).named.size() == at.named.size())
      continue;
    fmt::print(stderr,
               "raygrid: {}: {}: varies with {} only; the other value applies "
               "to the other camera\n",
               Printable(c == 0 ? first : second), at.Text(),
               OperatingParameterName(own[0].condition));
  }
  return cameras;
}

void AddCameraArgument(CLI::App* command, std::string* path) {
  command
      ->add_option("camera", *path,
                   "camera.yaml (double precision) or .raygrid blob "
                   "(fixed point)")
      ->required();
}

Dataset ReadCameraFeatures(const std::string& path, const ImageSize& size,
                           const Pattern& pattern) {
  auto cameras = ReadFeatures(path);
  if (cameras.size() > 1)
    throw InputError(path +
                     ": contains features of several cameras; split it into "
                     "one file per camera");
  Dataset dataset = std::move(cameras.begin()->second);
  dataset.image_size = size;
  RequireConsistent(path, dataset, pattern);
  return dataset;
}

std::optional<ValidityMask> LoadValidityMask(const CameraInput& input) {
  if (input.blob) return input.blob->GetValidityMask();
  if (input.file.uncertainty) return input.file.uncertainty->mask;
  return std::nullopt;
}

std::optional<ValidityMask> SelectVisibleMask(const std::string& outside,
                                              const std::string& path,
                                              const CameraInput& input) {
  if (outside != "border") return std::nullopt;
  if (auto valid_region = LoadValidityMask(input)) return valid_region;
  throw Error(ExitCode::kUsage,
              path +
                  ": --outside border: the file has no valid region; omit the "
                  "option, or use a camera.yaml written by raygrid calibrate");
}

void WarnAboutFailedCalibration(const std::string& path,
                                const CameraFile& file) {
  if (file.assessment == "fail")
    fmt::print(stderr,
               "raygrid: {}: its calibration has verdict fail; see the report "
               "and calibrate again before using it\n",
               Printable(path));
}

void RequireSeparateFolders(const std::vector<std::string>& images,
                            const std::string& folder) {
  for (const std::string& image : images) {
    const auto among = std::filesystem::absolute(image).parent_path();
    std::error_code ignored;
    if (std::filesystem::equivalent(among, folder, ignored))
      throw Error(
          ExitCode::kOutputFailed,
          fmt::format(
              "{}: contains the input image {}; use another output folder, so "
              "that outputs are not read as images next time",
              folder, image));
  }
}

void PrintOrWrite(const std::string& path, const std::string& text) {
  if (!path.empty())
    WriteFile(path, text);
  else if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() ||
           std::fflush(stdout) != 0)
    throw Error(ExitCode::kOutputFailed, "cannot write to standard output");
}

std::string ConvertCsvToJson(const std::string& csv,
                             const std::vector<std::string>& columns) {
  const std::string name = "result";
  CsvReader table(name, csv, columns);
  std::string text = "[";
  while (table.Next()) {
    nlohmann::ordered_json row;
    for (const std::string& column : columns) {
      if (table.Text(column).empty())
        row[column] = nullptr;
      else if (column == "valid")
        row[column] = table.Number(column) != 0;
      else
        row[column] = table.Number(column);
    }
    text += text.size() > 1 ? ",\n" : "\n";
    std::istringstream lines(row.dump(2));
    for (std::string line; std::getline(lines, line);)
      text += (line[0] == '{' ? "  " : "\n  ") + line;
  }
  return text + (text.size() > 1 ? "\n]\n" : "]\n");
}

}  // namespace raygrid
