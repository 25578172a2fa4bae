#include "session_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>

#include "dataset/error.h"
#include "dataset/files.h"

namespace raygrid {
namespace {

namespace fs = std::filesystem;

// Nothing of the folder is one's own before.
int LockFolder(const std::string& folder) {
  const int lock = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock < 0) FailToWrite(folder, errno);
  if (flock(lock, LOCK_EX | LOCK_NB) == 0) return lock;
  close(lock);
  throw Error(ExitCode::kOutput,
              folder +
                  ": another capture writes to it; end that first, or "
                  "choose another folder");
}

}  // namespace

SessionFolder::SessionFolder(const std::string& folder, const Pattern& pattern,
                             bool resume)
    : folder_(folder) {
  const bool is_session = IsSession(folder);
  if (is_session && !resume)
    throw Error(ExitCode::kOutput,
                folder +
                    ": holds a session; go on with it by --resume, or "
                    "choose another folder");
  if (resume && !is_session)
    throw Error(
        ExitCode::kInput,
        folder + ": holds no session to go on with; leave --resume out");
  RequireWritableFolder(folder);
  lock_ = LockFolder(folder);
  const std::string text = FormatPattern(pattern);
  const std::string path = (fs::path(folder) / kSessionPattern).string();
  if (resume) {
    session_ = ReadSession(folder);
    if (FormatPattern(ReadPattern(path)) != text)
      throw Error(ExitCode::kUsage,
                  folder +
                      ": is a session of another pattern; give it "
                      "--pattern " +
                      path);
  } else {
    is_new_ = true;
    WriteFile(path, text);
  }
  RequireWritableFolder((fs::path(folder) / kSessionFrames).string());
}

SessionFolder::~SessionFolder() {
  if (is_new_ && session_.frames.empty()) RemoveAll();
  if (lock_ >= 0) close(lock_);
}

// Leaves files of others, and the folders that have some.
void SessionFolder::RemoveAll() const {
  std::error_code error;
  for (const char* name : {kSessionFile, kSessionPattern, kSessionFrames, ""})
    fs::remove(fs::path(folder_) / name, error);
}

std::string SessionFolder::PathOf(const std::string& image) const {
  return (fs::path(folder_) / kSessionFrames / image).string();
}

std::string SessionFolder::NewName(const std::string& photograph) {
  const auto is_taken = [this](const std::string& name) {
    std::error_code error;
    return fs::exists(PathOf(name), error);
  };
  if (!photograph.empty() && !is_taken(photograph)) return photograph;
  std::string name;
  do name = fmt::format("frame-{:04d}.png", ++number_);
  while (is_taken(name));
  return name;
}

void SessionFolder::Keep(const ImageSize& size, const SessionFrame& frame,
                         std::string image_bytes) {
  if (session_.frames.empty()) session_.image_size = size;
  WriteFile(PathOf(frame.image), std::move(image_bytes));
  session_.frames.push_back(frame);
  Write();
}

void SessionFolder::Remove(const std::string& image) {
  auto& frames = session_.frames;
  const auto found = std::find_if(
      frames.begin(), frames.end(),
      [&image](const SessionFrame& frame) { return frame.image == image; });
  if (found == frames.end()) return;
  frames.erase(found);
  Write();
  std::error_code error;
  fs::remove(PathOf(image), error);
}

void SessionFolder::NoteLocked(const std::vector<std::string>& locked,
                               const std::vector<std::string>& not_locked) {
  session_.locked = locked;
  session_.not_locked = not_locked;
  Write();
}

void SessionFolder::Write() {
  WriteFile((fs::path(folder_) / kSessionFile).string(),
            FormatSession(session_));
}

}  // namespace raygrid
