#ifndef RAYGRID_DATASET_FILES_H
#define RAYGRID_DATASET_FILES_H

#include <string>
#include <vector>

namespace raygrid {

/// A whole file or pipe as bytes; throws InputError if it cannot be read, for
/// devices, some of which never end, and for pipes that nobody writes to within
/// a few seconds.
std::string ReadFile(const std::string& path);

/// Whether a link in the place of a file is the user's, who wants what it leads
/// to replaced, or is itself in the way.
enum class Links { kFollow, kReplace };

/// Files that appear together: all are written beside their targets first, and
/// renamed only when every one is complete. Throws Error(kOutput) and leaves
/// nothing behind otherwise. Missing folders are made. Pipes and devices stay,
/// and get the contents; so do they that links lead to, unless these are
/// replaced.
class OutputFiles {
 public:
  void Add(const std::string& path, std::string contents,
           Links links = Links::kFollow);
  void Commit();

 private:
  struct File {
    std::string path, contents;
    Links links;
  };
  std::vector<File> files_;
};

/// Throws the Error(kOutput) of a path that cannot be written, for the reason
/// that errno gave.
[[noreturn]] void FailToWrite(const std::string& path, int error);

/// One file alone.
void WriteFile(const std::string& path, std::string contents);

/// Throws Error(kOutput) if a file to be written is one that is read, under
/// whatever name; empty names are none.
void RequireNoInputReplaced(const std::vector<std::string>& inputs,
                            const std::vector<std::string>& outputs);

/// Throws Error(kOutput) early if files cannot be made in a folder, which is
/// created if it does not exist; Error(kUsage) rather than create one with the
/// name of a file, such as camera.yaml.
void RequireWritableFolder(const std::string& folder);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_FILES_H
