#ifndef RAYGRID_DATASET_OUTPUT_FOLDER_H
#define RAYGRID_DATASET_OUTPUT_FOLDER_H

#include <set>
#include <string>

namespace raygrid {

/// A folder whose files are replaced atomically. They are first written to a
/// hidden folder next to it, and both are then exchanged in one step: after a
/// crash, the folder contains all old or all new files, never a mixture. Other
/// files in the folder are kept.
///
/// Where folders cannot be exchanged (a mount point, the working directory, a
/// folder with other subfolders, an unsupported file system), the old files are
/// removed one by one, before the new ones are moved: a crash then leaves some
/// of the new files.
class OutputFolder {
 public:
  /// Creates the folder if needed, and the hidden temporary folder. Throws
  /// Error(kOutputFailed).
  explicit OutputFolder(const std::string& folder);
  /// Removes the hidden folder, including files that were not committed.
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Returns the hidden folder, where files are written.
  const std::string& path() const { return hidden_; }

  /// Replaces the folder's files by the new files of the same names, and
  /// removes stale files, given by their relative paths. Throws
  /// Error(kOutputFailed), leaving the folder unchanged.
  void Commit(const std::set<std::string>& stale);

 private:
  std::string folder_;  // without symbolic links
  std::string hidden_;
  int lock_ = -1;  // locks the hidden folder
};

}  // namespace raygrid

#endif  // RAYGRID_DATASET_OUTPUT_FOLDER_H
