#include "features/detection_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "dataset/content_hash.h"
#include "dataset/error.h"
#include "dataset/files.h"

namespace raygrid {
namespace {

namespace fs = std::filesystem;

// Must be incremented when the detector's results change for the same image.
constexpr int kDetectorVersion = 11;
constexpr const char* kExtension = ".detection";

// Returns the checksum of an entry and its key, so that an entry stored under
// another key is rejected.
std::string Checksum(const std::string& key, const std::string& entry) {
  ContentHash hash;
  hash.Add(key);
  hash.Add(entry);
  return hash.Text();
}

std::string FormatFeature(const char* word, const Feature& f) {
  return fmt::format("{} {} {} {} {:.17g} {:.17g}", word, f.board, f.column,
                     f.row, f.pixel.x(), f.pixel.y());
}

std::string EscapeNewlines(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

std::string FormatEntry(const DetectedImage& seen) {
  std::string entry =
      fmt::format("size {} {}\n", seen.size.width, seen.size.height);
  for (const Feature& feature : seen.detection.features)
    entry += FormatFeature("feature", feature) + "\n";
  for (const RejectedFeature& rejected : seen.detection.rejected)
    entry += FormatFeature("rejected", rejected.feature) + " " +
             EscapeNewlines(rejected.reason) + "\n";
  for (const std::string& warning : seen.detection.warnings)
    entry += "remark " + EscapeNewlines(warning) + "\n";
  return entry;
}

// Returns the rest of a line after the space.
std::string GetRestOfLine(std::istringstream* line) {
  std::string rest;
  line->get();
  std::getline(*line, rest);
  return rest;
}

Feature ParseFeature(std::istringstream* line) {
  Feature feature;
  std::string x, y;  // streams cannot parse all printed values, e.g. "inf"
  *line >> feature.board >> feature.column >> feature.row >> x >> y;
  feature.pixel = {std::strtod(x.c_str(), nullptr),
                   std::strtod(y.c_str(), nullptr)};
  return feature;
}

// Parses the detection of an image from an entry with a valid checksum.
DetectedImage ParseEntry(const std::string& entry) {
  DetectedImage seen;
  std::istringstream lines(entry);
  for (std::string text; std::getline(lines, text);) {
    std::istringstream line(text);
    std::string word;
    line >> word;
    if (word == "size") line >> seen.size.width >> seen.size.height;
    if (word == "feature")
      seen.detection.features.push_back(ParseFeature(&line));
    if (word == "rejected") {
      const Feature feature = ParseFeature(&line);
      seen.detection.rejected.push_back({feature, GetRestOfLine(&line)});
    }
    if (word == "remark")
      seen.detection.warnings.push_back(GetRestOfLine(&line));
  }
  return seen;
}

struct FileWithTime {
  fs::file_time_type time;
  fs::path path;
  bool operator<(const FileWithTime& other) const { return time < other.time; }
};

}  // namespace

std::string DetectionCache::DefaultFolder() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  // The XDG specification requires that relative paths are ignored.
  if (cache && fs::path(cache).is_absolute())
    return (fs::path(cache) / "raygrid").string();
  const char* home = std::getenv("HOME");
  if (!home || !fs::path(home).is_absolute()) return "";
  return (fs::path(home) / ".cache" / "raygrid").string();
}

std::string DetectionCache::Key(const std::string& image_bytes,
                                const Pattern& pattern,
                                const DetectionOptions& options) {
  ContentHash hash;
  hash.Add(RAYGRID_VERSION);
  hash.Add(fmt::format("{} {} {}", kDetectorVersion,
                       static_cast<int>(options.refinement),
                       options.window_px));
  hash.Add(pattern.yaml);
  hash.Add(image_bytes);
  return hash.Text();
}

std::optional<DetectedImage> DetectionCache::Find(
    const std::string& key) const {
  std::error_code error;
  if (folder_.empty() || !fs::exists(Path(key), error)) return std::nullopt;
  try {
    const std::string text = ReadFile(Path(key));
    const size_t end = text.find('\n');
    if (end == std::string::npos) return std::nullopt;
    const std::string entry = text.substr(end + 1);
    if (text.substr(0, end) != Checksum(key, entry)) return std::nullopt;
    return ParseEntry(entry);
  } catch (const Error&) {
    return std::nullopt;
  }
}

void DetectionCache::Store(const std::string& key,
                           const DetectedImage& seen) const {
  if (folder_.empty()) return;
  const std::string entry = FormatEntry(seen);
  try {
    WriteFile(Path(key), Checksum(key, entry) + "\n" + entry);
  } catch (const Error&) {
    // Without a cache entry, the image is detected again next time.
  }
}

void DetectionCache::Trim(int max_files) const {
  std::error_code error;
  std::vector<FileWithTime> files;
  for (fs::directory_iterator i(folder_, error), end; !error && i != end;
       i.increment(error)) {
    if (i->path().extension() != kExtension) continue;
    const fs::file_time_type time = fs::last_write_time(i->path(), error);
    if (!error) files.push_back({time, i->path()});
    error.clear();
  }
  if (static_cast<int>(files.size()) <= max_files) return;
  std::sort(files.begin(), files.end());
  files.resize(files.size() - max_files);
  for (const FileWithTime& file : files) fs::remove(file.path, error);
}

std::string DetectionCache::Path(const std::string& key) const {
  return (fs::path(folder_) / (key + kExtension)).string();
}

}  // namespace raygrid
