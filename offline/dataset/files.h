#ifndef RAYGRID_DATASET_FILES_H
#define RAYGRID_DATASET_FILES_H

#include <string>
#include <vector>

namespace raygrid {

/// A whole file as bytes; throws InputError if it cannot be read.
std::string ReadFile(const std::string& path);

/// Files that appear together: all are written beside their targets first, and
/// renamed only when every one is complete. Throws Error(kOutput) and leaves
/// nothing behind otherwise. Missing folders are made. Links stay, and what
/// they lead to is replaced; pipes and devices stay, and get the contents.
class OutputFiles {
 public:
  void Add(const std::string& path, std::string contents);
  void Commit();

 private:
  struct File {
    std::string path, contents;
  };
  std::vector<File> files_;
};

/// One file alone.
void WriteFile(const std::string& path, std::string contents);

/// Throws Error(kOutput) early if files cannot be made in a folder, which is
/// created if it does not exist.
void RequireWritableFolder(const std::string& folder);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_FILES_H
