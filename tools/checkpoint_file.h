#ifndef RAYGRID_TOOLS_CHECKPOINT_FILE_H
#define RAYGRID_TOOLS_CHECKPOINT_FILE_H

#include <chrono>
#include <string>
#include <vector>

#include "evaluation/checkpoint.h"

namespace raygrid {

/// resume.json while a calibration is at work: a program that is killed leaves
/// it. The result that is written to the folder takes it away, and so does a
/// calibration that fails.
class CheckpointFile {
 public:
  /// inputs are SerializeInputs() those cameras.
  CheckpointFile(const std::string& folder, const std::string& inputs,
                 size_t num_cameras);
  ~CheckpointFile();
  CheckpointFile(const CheckpointFile&) = delete;
  CheckpointFile& operator=(const CheckpointFile&) = delete;

  /// Takes up what was written before, if anything was: a calibration that was
  /// killed soon has written nothing. Throws as ReadCheckpoints().
  void Read();
  const Checkpoint& Of(size_t camera) const { return checkpoints_[camera]; }

  /// Writes them all, now or with one of the next.
  void Save(size_t camera, const Checkpoint& checkpoint);

 private:
  std::string path_, inputs_;
  std::vector<Checkpoint> checkpoints_;
  std::chrono::steady_clock::time_point next_write_ = {};
  bool is_written_ = false;
};

/// Keeps a finished result from being replaced by what was found so far: where
/// the folder holds one, this writes resume.json alone and throws
/// Error(kNotConverged). Without checkpoints, nothing was interrupted.
void PreserveFinishedResult(const std::string& folder,
                            const std::vector<Checkpoint>& checkpoints,
                            const std::string& inputs);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_CHECKPOINT_FILE_H
