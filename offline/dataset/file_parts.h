#ifndef RAYGRID_DATASET_FILE_PARTS_H
#define RAYGRID_DATASET_FILE_PARTS_H

#include <functional>
#include <string>
#include <vector>

namespace raygrid {

/// Files that are parts of others, such as the images of a bag: ReadFile()
/// reads their paths, which do not exist on the disk, by a function.
struct FileParts {
  /// Returns the contents of a part. Thread-safe. Throws InputError.
  std::function<std::string(const std::string& path)> read;
  std::vector<std::string> files;  ///< that contain the parts
};

/// Registers parts by their paths until the program ends. To be called before
/// threads read files. Throws InputError if a path is that of a file, or is
/// registered already.
void AddFileParts(const std::vector<std::string>& paths, FileParts parts);

/// Returns the files that contain a part; the path itself for other files.
std::vector<std::string> FilesOf(const std::string& path);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_FILE_PARTS_H
