#include "dataset/output_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <vector>

#include "dataset/files.h"

namespace raygrid {
namespace {

namespace fs = std::filesystem;

// ---- The hidden folder -----------------------------------------------------

// Name prefix, before a number, of the hidden folder within the output folder.
constexpr char kHiddenPrefix[] = ".raygrid-";

// Locks and empties a folder; returns 0 or an errno.
int LockEmptied(const std::string& path, int file) {
  struct stat status;
  if (fstat(file, &status) != 0) return errno;
  if (status.st_uid != geteuid()) return EPERM;
  if (flock(file, LOCK_EX | LOCK_NB) != 0) return errno;
  std::error_code error, ignored;
  for (const auto& entry : fs::directory_iterator(path, ignored))
    fs::remove_all(entry.path(), ignored);
  const bool is_empty = fs::is_empty(path, error);
  if (error) return error.value();
  return is_empty ? 0 : ENOTEMPTY;
}

// Locks a folder, which is created or was left by a killed process and is then
// emptied. Returns nullopt if another process uses it or another user owns it.
std::optional<int> LockNewFolder(const std::string& path) {
  const bool is_new = mkdir(path.c_str(), 0700) == 0;
  if (!is_new && errno != EEXIST) ThrowWriteError(path, errno);
  const int file =
      open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  const int error = file < 0 ? errno : LockEmptied(path, file);
  if (error == 0) return file;
  if (file >= 0) close(file);
  if (is_new && error != EWOULDBLOCK) {  // other names would also fail
    rmdir(path.c_str());
    ThrowWriteError(path, error);
  }
  return std::nullopt;
}

bool IsMountPoint(const std::string& folder) {
  struct statx status;
  return statx(AT_FDCWD, folder.c_str(), 0, STATX_TYPE, &status) == 0 &&
         (status.stx_attributes & STATX_ATTR_MOUNT_ROOT) != 0;
}

bool IsWorkingDirectoryIn(const fs::path& folder) {
  std::error_code error;
  const fs::path here = fs::current_path(error);
  return !error &&
         std::mismatch(folder.begin(), folder.end(), here.begin(), here.end())
                 .first == folder.end();
}

// Returns the path prefix of the hidden folder: next to the output folder if
// the two can be exchanged, otherwise within it.
std::string HiddenPrefix(const fs::path& folder) {
  const fs::path parent = folder.parent_path();
  const bool uses_sibling_folder =
      folder.has_relative_path() && access(parent.c_str(), W_OK | X_OK) == 0 &&
      !IsMountPoint(folder) && !IsWorkingDirectoryIn(folder);
  return uses_sibling_folder
             ? (parent / ("." + folder.filename().string() + ".raygrid-"))
                   .string()
             : (folder / kHiddenPrefix).string();
}

// ---- Contents --------------------------------------------------------------

// Relative paths within a folder; sorting puts parents before their contents.
using Paths = std::set<std::string>;

struct Contents {
  Paths files, folders;
};

// Lists a folder's contents except the hidden folder; symbolic links count as
// files.
Contents ListContents(const std::string& folder, const std::string& hidden) {
  Contents contents;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end;
       !error && it != end; it.increment(error)) {
    if (it->path() == hidden) {
      it.disable_recursion_pending();
      continue;
    }
    const bool is_folder = it->is_directory() && !it->is_symlink();
    (is_folder ? contents.folders : contents.files)
        .insert(it->path().lexically_relative(folder).string());
  }
  if (error) ThrowWriteError(folder, error.value());
  return contents;
}

bool Has(const Paths& paths, const std::string& path) {
  return paths.count(path) > 0;
}

// Whether the commit removes a file: it is overwritten or stale.
bool IsObsolete(const std::string& path, const Contents& written,
                const Paths& stale) {
  return Has(written.files, path) || Has(written.folders, path) ||
         Has(stale, path);
}

bool ContainsStaleFiles(const std::string& folder, const Paths& stale) {
  return std::any_of(stale.begin(), stale.end(), [&](const std::string& file) {
    return fs::path(file).parent_path() == folder;
  });
}

void Synchronize(const std::string& path) {
  const int file = open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC);
  if (file < 0) ThrowWriteError(path, errno);
  const int error = fsync(file) == 0 ? 0 : errno;
  close(file);
  // Some file systems do not support fsync() of folders.
  if (error != 0 && error != EINVAL) ThrowWriteError(path, error);
}

// Flushes the files written by this process to disk, not those of others.
void SynchronizeAll(const std::string& folder, const Contents& written) {
  for (const std::string& path : written.files)
    Synchronize(folder + "/" + path);
  for (const std::string& path : ListContents(folder, "").folders)
    Synchronize(folder + "/" + path);
  Synchronize(folder);
}

// ---- All at once -----------------------------------------------------------

// Copies mode and owner; returns false if this fails.
bool CopyOwner(const std::string& from, const std::string& to) {
  struct stat status, own;
  if (stat(from.c_str(), &status) != 0 || stat(to.c_str(), &own) != 0 ||
      chmod(to.c_str(), status.st_mode & 07777) != 0)
    return false;
  return (status.st_uid == own.st_uid && status.st_gid == own.st_gid) ||
         chown(to.c_str(), status.st_uid, status.st_gid) == 0;
}

// Hard-links the remaining files of the old folder, which are neither replaced
// nor stale, into the new one. On failure, removes all links and returns false.
bool LinkUnwrittenFiles(const std::string& folder, const Contents& old,
                        const std::string& hidden, const Contents& written,
                        const Paths& stale) {
  std::vector<std::string> linked;
  for (const std::string& path : old.files) {
    if (IsObsolete(path, written, stale)) continue;
    const std::string link = hidden + "/" + path;
    std::error_code ignored;
    fs::create_directories(fs::path(link).parent_path(), ignored);
    if (linkat(AT_FDCWD, (folder + "/" + path).c_str(), AT_FDCWD, link.c_str(),
               0) == 0) {
      linked.push_back(link);
      continue;
    }
    for (const std::string& done : linked) unlink(done.c_str());
    return false;
  }
  return true;
}

// Whether the old folder has subfolders that are neither written nor contain
// stale files.
bool HasForeignFolders(const Contents& old, const Contents& written,
                       const Paths& stale) {
  return std::any_of(old.folders.begin(), old.folders.end(),
                     [&](const std::string& folder) {
                       return !Has(written.folders, folder) &&
                              !ContainsStaleFiles(folder, stale);
                     });
}

// After the exchange, the old files are in the hidden folder: removes the
// listed ones and moves back files that were added since.
void RemoveOld(const std::string& hidden, const std::string& folder,
               const Contents& listed) {
  const Contents now = ListContents(hidden, "");
  for (const std::string& path : now.files) {
    const std::string file = hidden + "/" + path;
    if (Has(listed.files, path))
      unlink(file.c_str());
    else
      std::rename(file.c_str(), (folder + "/" + path).c_str());
  }
  for (auto path = now.folders.rbegin(); path != now.folders.rend(); ++path)
    rmdir((hidden + "/" + *path).c_str());
  rmdir(hidden.c_str());
}

// Replaces the folder atomically; returns false if the folders cannot be
// exchanged.
bool ExchangeFolders(const std::string& folder, const Contents& old,
                     const std::string& hidden, const Contents& written,
                     const Paths& stale) {
  if (fs::path(hidden).parent_path() == folder ||
      HasForeignFolders(old, written, stale) || !CopyOwner(folder, hidden) ||
      !LinkUnwrittenFiles(folder, old, hidden, written, stale))
    return false;
  SynchronizeAll(hidden, written);
  if (renameat2(AT_FDCWD, hidden.c_str(), AT_FDCWD, folder.c_str(),
                RENAME_EXCHANGE) != 0) {
    for (const std::string& path : ListContents(hidden, "").files)
      if (!Has(written.files, path)) unlink((hidden + "/" + path).c_str());
    return false;
  }
  Synchronize(fs::path(folder).parent_path().string());
  RemoveOld(hidden, folder, old);
  return true;
}

// ---- One by one ------------------------------------------------------------

// Replaces files one by one. The hidden folder is within the output folder, so
// all renames are within one file system.
void MoveFilesIndividually(const std::string& folder, const Contents& old,
                           const std::string& hidden, const Contents& written,
                           const Paths& stale) {
  SynchronizeAll(hidden, written);
  for (const std::string& path : old.files)
    if (IsObsolete(path, written, stale)) unlink((folder + "/" + path).c_str());
  for (const std::string& path : old.folders)
    if (!Has(written.folders, path) && ContainsStaleFiles(path, stale))
      rmdir((folder + "/" + path).c_str());  // fails if others have files there
  for (const std::string& path : written.folders) {
    const std::string made = folder + "/" + path;
    if (mkdir(made.c_str(), 0777) != 0 && errno != EEXIST)
      ThrowWriteError(made, errno);
  }
  for (const std::string& path : written.files) {
    const std::string file = folder + "/" + path;
    if (std::rename((hidden + "/" + path).c_str(), file.c_str()) != 0)
      ThrowWriteError(file, errno);
  }
  for (const std::string& path : written.folders)
    Synchronize(folder + "/" + path);
  Synchronize(folder);
}

}  // namespace

OutputFolder::OutputFolder(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error) folder_ = fs::canonical(folder, error).string();
  if (error) ThrowWriteError(folder, error.value());
  const std::string prefix = HiddenPrefix(folder_);
  for (int k = 0; lock_ < 0; ++k) {
    if (k == 100) ThrowWriteError(hidden_, EEXIST);
    hidden_ = prefix + std::to_string(k);
    lock_ = LockNewFolder(hidden_).value_or(-1);
  }
}

OutputFolder::~OutputFolder() {
  std::error_code error, ignored;
  if (!hidden_.empty()) fs::remove_all(hidden_, error);
  close(lock_);
  // Retries: the lock may have used the last available file descriptor.
  if (error) fs::remove_all(hidden_, ignored);
}

void OutputFolder::Commit(const std::set<std::string>& stale) {
  const Contents old = ListContents(folder_, hidden_),
                 written = ListContents(hidden_, "");
  for (const std::string& path : written.files)
    if (Has(old.folders, path)) ThrowWriteError(folder_ + "/" + path, EISDIR);
  if (ExchangeFolders(folder_, old, hidden_, written, stale)) {
    hidden_.clear();
    return;
  }
  const std::string within = folder_ + "/" + kHiddenPrefix;
  if (fs::path(hidden_).parent_path() != folder_) {
    std::error_code ignored;
    fs::remove_all(within, ignored);
    if (std::rename(hidden_.c_str(), within.c_str()) != 0)
      ThrowWriteError(folder_, errno);
    hidden_ = within;
  }
  MoveFilesIndividually(folder_, old, hidden_, written, stale);
}

}  // namespace raygrid
