#include "checkpoint_file.h"

#include <fmt/format.h>

#include <exception>
#include <filesystem>
#include <utility>

#include "dataset/error.h"
#include "dataset/files.h"
#include "report/checkpoint_json.h"
#include "report/result_folder.h"

namespace raygrid {
namespace {

using Clock = std::chrono::steady_clock;

}  // namespace

CheckpointFile::CheckpointFile(const std::string& folder,
                               const std::string& inputs, size_t num_cameras)
    : path_((std::filesystem::path(folder) / "resume.json").string()),
      inputs_(inputs),
      checkpoints_(num_cameras) {}

void CheckpointFile::Read() {
  std::error_code ignored;
  if (!std::filesystem::exists(path_, ignored)) return;
  std::vector<Checkpoint> read = ReadCheckpoints(path_, inputs_);
  if (read.size() != checkpoints_.size())
    throw InputError(
        path_ + ": belongs to a rig with other cameras; run without --resume");
  checkpoints_ = std::move(read);
}

void CheckpointFile::Save(size_t camera, const Checkpoint& checkpoint) {
  checkpoints_[camera] = checkpoint;
  const auto start = Clock::now();
  if (start < next_write_) return;
  try {
    OutputFiles files;
    files.Add(path_, FormatCheckpoints(checkpoints_, inputs_), Links::kReplace);
    files.Commit();
    is_written_ = true;
  } catch (const Error&) {
    // A failed checkpoint must not abort the calibration.
  }
  // Limits the time spent on writing to a tenth of the total.
  const auto end = Clock::now();
  next_write_ = end + 9 * (end - start);
}

CheckpointFile::~CheckpointFile() {
  if (is_written_ && std::uncaught_exceptions() > 0) {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
}

void PreserveFinishedResult(const std::string& folder,
                            const std::vector<Checkpoint>& checkpoints,
                            const std::string& inputs) {
  if (checkpoints.empty() || !HasFinishedResult(folder)) return;
  OutputFiles files;
  files.Add((std::filesystem::path(folder) / "resume.json").string(),
            FormatCheckpoints(checkpoints, inputs), Links::kReplace);
  files.Commit();
  throw Error(ExitCode::kNotConverged,
              fmt::format("interrupted; {} still contains the previous result; "
                          "continue this calibration with --resume",
                          folder));
}

}  // namespace raygrid
