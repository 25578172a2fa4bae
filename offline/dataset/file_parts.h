#ifndef RAYGRID_DATASET_FILE_PARTS_H
#define RAYGRID_DATASET_FILE_PARTS_H

#include <functional>
#include <string>
#include <vector>

namespace raygrid {

/// Files that are parts of others, such as the images of a bag: ReadFile()
/// reads FOLDER/NAME, which does not exist on the disk, by a function.
struct FileParts {
  /// Returns the contents of a part. Thread-safe. Throws InputError.
  std::function<std::string(const std::string& name)> read;
  std::vector<std::string> files;  ///< that contain the parts
};

/// Registers the parts in a folder until the program ends. To be called before
/// threads read files.
void AddFileParts(const std::string& folder, FileParts parts);

/// Returns the files that contain a part; the path itself for other files.
std::vector<std::string> FilesOf(const std::string& path);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_FILE_PARTS_H
