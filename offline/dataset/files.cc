#include "dataset/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "dataset/error.h"

namespace raygrid {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void Fail(const std::string& path, int error) {
  throw Error(ExitCode::kOutput,
              fmt::format("{}: cannot be written ({}); choose another place "
                          "with -o, or make room there",
                          path, std::strerror(error)));
}

// The folder of a path, created if need be.
void MakeFolderOf(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  std::error_code error;
  if (!folder.empty()) fs::create_directories(folder, error);
  if (error) Fail(folder.string(), error.value());
}

std::string TemporaryName(const std::string& path) {
  return fmt::format("{}.part-{}", path, getpid());
}

// What there is under a name and is no file: a pipe or a device, which gets the
// contents and stays what it is.
bool IsStream(const std::string& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  return fs::exists(status) && !fs::is_regular_file(status);
}

// The file that a link leads to: that one is replaced, and the link stays.
std::string FollowLinks(const std::string& path) {
  std::error_code error;
  const fs::path file = fs::canonical(path, error);
  return error ? path : file.string();
}

// Returns 0 or an errno.
int WriteWhole(const std::string& path, const std::string& contents) {
  const int file =
      open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file < 0) return errno;
  int error = 0;
  for (size_t done = 0; done < contents.size() && error == 0;) {
    const ssize_t written =
        write(file, contents.data() + done, contents.size() - done);
    if (written >= 0)
      done += static_cast<size_t>(written);
    else if (errno != EINTR)
      error = errno;
  }
  if (close(file) != 0 && error == 0) error = errno;
  return error;
}

int Rename(const std::string& from, const std::string& to) {
  return rename(from.c_str(), to.c_str()) == 0 ? 0 : errno;
}

}  // namespace

std::string ReadFile(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error))
    throw InputError(path + ": is a folder, where a file was expected");
  std::ifstream file(path, std::ios::binary);
  std::stringstream contents;
  if (file) contents << file.rdbuf();
  if (!file)
    throw InputError(
        fmt::format("{}: cannot be read ({}); check the name and permissions",
                    path, std::strerror(errno ? errno : EIO)));
  return contents.str();
}

void OutputFiles::Add(const std::string& path, std::string contents) {
  files_.push_back({FollowLinks(path), std::move(contents)});
}

void OutputFiles::Commit() {
  const auto remove_temporaries = [this] {
    for (const File& file : files_) unlink(TemporaryName(file.path).c_str());
  };
  for (const File& file : files_) {
    MakeFolderOf(file.path);
    std::error_code ignored;
    if (fs::is_directory(file.path, ignored)) Fail(file.path, EISDIR);
  }
  for (const File& file : files_) {
    if (IsStream(file.path)) continue;
    const int error = WriteWhole(TemporaryName(file.path), file.contents);
    if (error == 0) continue;
    remove_temporaries();
    Fail(file.path, error);
  }
  for (const File& file : files_) {
    const int error = IsStream(file.path)
                          ? WriteWhole(file.path, file.contents)
                          : Rename(TemporaryName(file.path), file.path);
    if (error == 0) continue;
    remove_temporaries();
    Fail(file.path, error);
  }
  files_.clear();
}

void WriteFile(const std::string& path, std::string contents) {
  OutputFiles files;
  files.Add(path, std::move(contents));
  files.Commit();
}

void RequireWritableFolder(const std::string& folder) {
  const std::string probe = (fs::path(folder) / ".raygrid").string();
  MakeFolderOf(probe);
  const int error = WriteWhole(TemporaryName(probe), "");
  unlink(TemporaryName(probe).c_str());
  if (error != 0) Fail(folder, error);
}

}  // namespace raygrid
