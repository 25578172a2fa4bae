#ifndef RAYGRID_TOOLS_CHECKPOINT_FILE_H
#define RAYGRID_TOOLS_CHECKPOINT_FILE_H

#include <chrono>
#include <string>
#include <vector>

#include "evaluation/checkpoint.h"

namespace raygrid {

/// resume.json during a calibration, which remains if the program is killed. It
/// is removed when the result is written to the folder, or when the calibration
/// fails.
class CheckpointFile {
 public:
  /// inputs: SerializeInputs() of the cameras
  CheckpointFile(const std::string& folder, const std::string& inputs,
                 size_t num_cameras);
  ~CheckpointFile();
  CheckpointFile(const CheckpointFile&) = delete;
  CheckpointFile& operator=(const CheckpointFile&) = delete;

  /// Reads the file of an interrupted calibration, if it exists; it does not if
  /// the program was killed early. Throws as ReadCheckpoints().
  void Read();
  const Checkpoint& Of(size_t camera) const { return checkpoints_[camera]; }

  /// Stores a checkpoint, and writes all of them, at limited frequency.
  void Save(size_t camera, const Checkpoint& checkpoint);

 private:
  std::string path_, inputs_;
  std::vector<Checkpoint> checkpoints_;
  std::chrono::steady_clock::time_point next_write_ = {};
  bool is_written_ = false;
};

/// Keeps a finished result from being replaced by intermediate ones: if the
/// folder contains a result, writes only resume.json and throws
/// Error(kNotConverged). Without checkpoints, no calibration was interrupted.
void PreserveFinishedResult(const std::string& folder,
                            const std::vector<Checkpoint>& checkpoints,
                            const std::string& inputs);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_CHECKPOINT_FILE_H
