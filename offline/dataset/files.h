#ifndef RAYGRID_DATASET_FILES_H
#define RAYGRID_DATASET_FILES_H

#include <string>
#include <vector>

namespace raygrid {

/// Reads a whole file or pipe; throws InputError if it is unreadable, a device
/// (some never end), or a pipe without a writer for a few seconds.
std::string ReadFile(const std::string& path);

/// Whether symbolic links to the file to replace are followed, or replaced
/// themselves.
enum class Links { kFollow, kReplace };

/// Files that are written atomically as a group: temporary files in the folders
/// of the targets are renamed when all are complete. Otherwise throws
/// Error(kOutputFailed) and removes them. Creates missing folders. Pipes and
/// devices are written directly, also through links, unless links are replaced.
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

/// Throws Error(kOutputFailed) for a path that is not writable; error is errno.
[[noreturn]] void ThrowWriteError(const std::string& path, int error);

/// Writes a single file.
void WriteFile(const std::string& path, std::string contents);

/// Throws Error(kOutputFailed) if an output file is also an input, under any
/// name; empty names are ignored.
void RequireNoInputReplaced(const std::vector<std::string>& inputs,
                            const std::vector<std::string>& outputs);

/// Throws Error(kOutputFailed) early if a folder, which is created if missing,
/// is not writable; Error(kUsage) instead of creating a folder with the name of
/// a file, such as camera.yaml.
void RequireWritableFolder(const std::string& folder);

/// The same, but does not leave a folder behind that did not exist.
void RequireCreatableFolder(const std::string& folder);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_FILES_H
