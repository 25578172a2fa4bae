#include "dataset/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <thread>

#include "dataset/error.h"
#include "dataset/file_parts.h"

namespace raygrid {
namespace {

namespace fs = std::filesystem;

// Parts of files, by path.
using PartsByPath = std::map<std::string, std::shared_ptr<const FileParts>>;
PartsByPath& GetFileParts() {
  static PartsByPath parts;
  return parts;
}

// Returns null if a file is not a part of another one.
const FileParts* FindFileParts(const std::string& path) {
  const auto found = GetFileParts().find(path);
  return found == GetFileParts().end() ? nullptr : found->second.get();
}

// Throws if a folder to be created has a typical file extension: the user then
// expects a file.
void RequireFolderName(const fs::path& folder) {
  const std::string extension = folder.extension().string();
  for (const char* known :
       {".csv", ".html", ".jpg", ".json", ".pdf", ".png", ".raygrid", ".toml",
        ".txt", ".xml", ".yaml", ".yml"})
    if (extension == known && !fs::exists(folder))
      throw Error(ExitCode::kUsage,
                  fmt::format("{}: the output is a folder, but this is the "
                              "name of a {} file; specify a folder such as {}",
                              folder.string(), extension.substr(1),
                              folder.stem().string()));
}

// Creates the parent folder of a path if it does not exist.
void CreateParentFolder(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  RequireFolderName(folder);
  std::error_code error;
  if (!folder.empty()) fs::create_directories(folder, error);
  if (error) ThrowWriteError(folder.string(), error.value());
}

std::string TemporaryName(const std::string& path) {
  return fmt::format("{}.part-{}", path, getpid());
}

// Whether a path is a pipe or a device, which is written to instead of being
// replaced.
bool IsPipeOrDevice(const std::string& path, Links links) {
  std::error_code ignored;
  const fs::file_status status = links == Links::kFollow
                                     ? fs::status(path, ignored)
                                     : fs::symlink_status(path, ignored);
  return fs::exists(status) && !fs::is_regular_file(status) &&
         !fs::is_symlink(status);
}

// Returns the target of a symbolic link: the target is replaced, and the link
// is kept.
std::string FollowLinks(const std::string& path) {
  std::error_code error;
  const fs::path file = fs::canonical(path, error);
  return error ? path : file.string();
}

// Writes contents to an open file; returns 0 or an errno.
int WriteAll(int fd, const std::string& contents) {
  if (fd < 0) return errno;
  int error = 0;
  for (size_t done = 0; done < contents.size() && error == 0;) {
    const ssize_t written =
        write(fd, contents.data() + done, contents.size() - done);
    if (written >= 0)
      done += static_cast<size_t>(written);
    else if (errno != EINTR)
      error = errno;
  }
  if (close(fd) != 0 && error == 0) error = errno;
  return error;
}

// Timeout for opening the other end of a pipe.
constexpr auto kWriterTimeout = std::chrono::seconds(5);

// Polls is_there until it returns true; returns false on timeout.
bool WaitFor(const std::function<bool()>& is_there) {
  const auto end = std::chrono::steady_clock::now() + kWriterTimeout;
  while (!is_there()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

// Writes to a pipe or a device; returns 0 or an errno.
int WriteStream(const std::string& path, const std::string& contents) {
  int file = -1;
  WaitFor([&] {
    file = open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK);
    return file >= 0 || errno != ENXIO;  // the pipe has no reader yet
  });
  if (file >= 0) fcntl(file, F_SETFL, 0);  // then wait for slow readers
  return WriteAll(file, contents);
}

// ---- Reading ---------------------------------------------------------------

class OpenFile {
 public:
  explicit OpenFile(const std::string& path)
      : file_(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {}
  ~OpenFile() {
    if (file_ >= 0) close(file_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  int number() const { return file_; }

 private:
  int file_;
};

// Whether a pipe has data or a writer: without a writer, read() returns end of
// file. The byte that is read is appended to contents.
bool HasWriter(int pipe, std::string* contents) {
  char first;
  const ssize_t size = read(pipe, &first, 1);
  if (size == 1) contents->push_back(first);
  return size != 0;
}

// Reads the rest of a file; returns 0 or an errno.
int ReadRest(int file, std::string* contents) {
  struct stat status = {};
  if (fstat(file, &status) == 0 && S_ISREG(status.st_mode))
    contents->reserve(static_cast<size_t>(status.st_size));
  std::vector<char> buffer(1 << 16);
  for (;;) {
    const ssize_t size = read(file, buffer.data(), buffer.size());
    if (size == 0) return 0;
    if (size > 0)
      contents->append(buffer.data(), static_cast<size_t>(size));
    else if (errno != EINTR)
      return errno;
  }
}

// Creates a file after removing one of the same name left by a killed process.
int WriteNew(const std::string& path, const std::string& contents) {
  unlink(path.c_str());
  return WriteAll(
      open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC,
           0666),
      contents);
}

int Rename(const std::string& from, const std::string& to) {
  return rename(from.c_str(), to.c_str()) == 0 ? 0 : errno;
}

}  // namespace

void ThrowWriteError(const std::string& path, int error) {
  throw Error(ExitCode::kOutputFailed,
              fmt::format("{}: cannot be written ({}); free disk space, or use "
                          "another path with -o",
                          path, std::strerror(error)));
}

void AddFileParts(const std::vector<std::string>& paths, FileParts parts) {
  const auto shared = std::make_shared<const FileParts>(std::move(parts));
  std::error_code error;
  for (const std::string& path : paths) {
    if (fs::exists(path, error))
      throw InputError(path + ": is a file and also part of a bag; rename it");
    if (!GetFileParts().emplace(path, shared).second)
      throw InputError(path + ": is given twice; omit one");
  }
}

std::vector<std::string> FilesOf(const std::string& path) {
  const FileParts* const parts = FindFileParts(path);
  return parts ? parts->files : std::vector<std::string>{path};
}

std::string ReadFile(const std::string& path) {
  if (const FileParts* const parts = FindFileParts(path))
    return parts->read(path);
  std::error_code error;
  if (fs::is_directory(path, error))
    throw InputError(path + ": is a folder, expected a file");
  if (fs::is_character_file(path, error) || fs::is_block_file(path, error))
    throw InputError(path + ": is a device, expected a file");
  const OpenFile file(path);
  std::string contents;
  if (file.number() >= 0 && fs::is_fifo(path, error) &&
      !WaitFor([&] { return HasWriter(file.number(), &contents); }))
    throw InputError(path +
                     ": no process writes to this pipe; start the writer "
                     "first, or use a file");
  int failure = file.number() < 0 ? errno : 0;
  if (failure == 0) {
    fcntl(file.number(), F_SETFL, 0);  // then wait for slow writers
    failure = ReadRest(file.number(), &contents);
  }
  if (failure != 0)
    throw InputError(
        fmt::format("{}: cannot be read ({}); check name and permissions", path,
                    std::strerror(failure)));
  return contents;
}

void OutputFiles::Add(const std::string& path, std::string contents,
                      Links links) {
  files_.push_back({links == Links::kFollow ? FollowLinks(path) : path,
                    std::move(contents), links});
}

void OutputFiles::Commit() {
  const auto remove_temporaries = [this] {
    for (const File& file : files_) unlink(TemporaryName(file.path).c_str());
  };
  for (const File& file : files_) {
    CreateParentFolder(file.path);
    std::error_code ignored;
    if (fs::is_directory(file.path, ignored) &&
        !(file.links == Links::kReplace && fs::is_symlink(file.path, ignored)))
      ThrowWriteError(file.path, EISDIR);
  }
  for (const File& file : files_) {
    if (IsPipeOrDevice(file.path, file.links)) continue;
    const int error = WriteNew(TemporaryName(file.path), file.contents);
    if (error == 0) continue;
    remove_temporaries();
    ThrowWriteError(file.path, error);
  }
  for (const File& file : files_) {
    const int error = IsPipeOrDevice(file.path, file.links)
                          ? WriteStream(file.path, file.contents)
                          : Rename(TemporaryName(file.path), file.path);
    if (error == 0) continue;
    remove_temporaries();
    ThrowWriteError(file.path, error);
  }
  files_.clear();
}

void WriteFile(const std::string& path, std::string contents) {
  OutputFiles files;
  files.Add(path, std::move(contents));
  files.Commit();
}

void RequireNoInputReplaced(const std::vector<std::string>& inputs,
                            const std::vector<std::string>& outputs) {
  using Identity = std::pair<dev_t, ino_t>;
  const auto identify = [](const std::string& path) {
    struct stat status = {};
    const bool is_file =
        stat(path.c_str(), &status) == 0 && S_ISREG(status.st_mode);
    return is_file ? std::optional(Identity(status.st_dev, status.st_ino))
                   : std::nullopt;
  };
  std::map<Identity, std::string> input_by_identity;
  for (const std::string& path : inputs)
    for (const std::string& file : FilesOf(path))
      if (const auto identity = identify(file))
        input_by_identity[*identity] = file;
  for (const std::string& path : outputs) {
    const auto identity = identify(path);
    if (identity && input_by_identity.count(*identity))
      throw Error(
          ExitCode::kOutputFailed,
          fmt::format(
              "{}: would overwrite the input {}; use another output path", path,
              input_by_identity[*identity]));
  }
}

void RequireWritableFolder(const std::string& folder) {
  const std::string probe = (fs::path(folder) / ".raygrid").string();
  CreateParentFolder(probe);
  const int error = WriteNew(TemporaryName(probe), "");
  unlink(TemporaryName(probe).c_str());
  if (error != 0) ThrowWriteError(folder, error);
}

void RequireCreatableFolder(const std::string& folder) {
  std::vector<fs::path> missing;
  for (fs::path path = fs::absolute(folder);
       !path.empty() && !fs::exists(path) && path != path.parent_path();
       path = path.parent_path())
    missing.push_back(path);
  RequireWritableFolder(folder);
  std::error_code ignored;
  for (const fs::path& path : missing) fs::remove(path, ignored);
}

}  // namespace raygrid
