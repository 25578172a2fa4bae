#ifndef RAYGRID_DATASET_OUTPUT_FOLDER_H
#define RAYGRID_DATASET_OUTPUT_FOLDER_H

#include <set>
#include <string>

namespace raygrid {

/// A folder whose files are replaced all at once. They are written into a
/// hidden folder beside it first, which then takes its place in one step: a
/// program that is killed leaves the old files or the new ones, never some of
/// each. Files of others in the folder stay.
///
/// The old files go one by one, before the new ones come, where folders cannot
/// change places (a mount point, the working directory, a folder of others
/// within, a file system that cannot do it): whoever is killed then leaves some
/// of the new ones.
class OutputFolder {
 public:
  /// Makes the folder if there is none, and the hidden one. Throws
  /// Error(kOutput).
  explicit OutputFolder(const std::string& folder);
  /// Removes the hidden folder, and with it all that was not committed.
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// The hidden folder: where to write.
  const std::string& path() const { return hidden_; }

  /// Puts what was written in the place of the folder's files of the same
  /// names, and of stale ones: those, given by their paths in the folder, go.
  /// Throws Error(kOutput), and the folder is as it was.
  void Commit(const std::set<std::string>& stale);

 private:
  std::string folder_;  // without links
  std::string hidden_;
  int lock_ = -1;  // on the hidden folder, while this lives
};

}  // namespace raygrid

#endif  // RAYGRID_DATASET_OUTPUT_FOLDER_H
