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

void RequireSameCameras(const std::string& folder,
                        const std::vector<Session>& sessions,
                        const std::vector<std::string>& cameras) {
  std::vector<std::string> names;
  for (const Session& session : sessions) names.push_back(session.camera);
  if (names == cameras) return;
  throw Error(
      ExitCode::kUsage,
      names.size() == 1
          ? folder +
                ": is a session of a single camera; specify a single --source"
          : fmt::format("{}: is a session of the cameras {}; specify --source "
                        "NAME=... for each of them, in this order",
                        folder, fmt::join(names, ", ")));
}

// Must be called before any access to the folder's files.
int LockFolder(const std::string& folder) {
  const int lock = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock < 0) ThrowWriteError(folder, errno);
  if (flock(lock, LOCK_EX | LOCK_NB) == 0) return lock;
  close(lock);
  throw Error(
      ExitCode::kOutputFailed,
      folder +
          ": in use by another capture; stop it first, or use another folder");
}

}  // namespace

SessionFolder::SessionFolder(const std::string& folder, const Pattern& pattern,
                             const std::vector<std::string>& cameras,
                             bool resume)
    : folder_(folder) {
  const bool is_session = IsSession(folder);
  if (is_session && !resume)
    throw Error(ExitCode::kOutputFailed,
                folder +
                    ": contains a session; continue it with "
                    "--resume, or use another folder");
  if (resume && !is_session)
    throw Error(ExitCode::kInvalidInput,
                folder + ": contains no session to resume; omit --resume");
  RequireWritableFolder(folder);
  lock_ = LockFolder(folder);
  const std::string text = FormatPattern(pattern);
  const std::string path = (fs::path(folder) / kSessionPattern).string();
  if (resume) {
    cameras_ = ReadSession(folder);
    RequireSameCameras(folder, cameras_, cameras);
    if (FormatPattern(ReadPattern(path)) != text)
      throw Error(
          ExitCode::kUsage,
          folder + ": is a session with another target; use --pattern " + path);
  } else {
    is_new_ = true;
    AdoptPattern(path, text);
    for (const std::string& camera : cameras) {
      cameras_.emplace_back();
      cameras_.back().camera = camera;
    }
  }
  RequireWritableFolder((fs::path(folder) / kSessionFrames).string());
  for (const std::string& camera : cameras)
    if (!camera.empty())
      RequireWritableFolder(
          (fs::path(folder) / kSessionFrames / camera).string());
}

// Writes the pattern file. An existing file is never replaced, since it may be
// the one given by the user.
void SessionFolder::AdoptPattern(const std::string& path,
                                 const std::string& text) {
  if (!fs::exists(path)) {
    WriteFile(path, text);
    has_made_pattern_ = true;
  } else if (FormatPattern(ReadPattern(path)) != text) {
    throw Error(ExitCode::kOutputFailed,
                path +
                    ": describes another target; pass it "
                    "with --pattern, or use another folder");
  }
}

SessionFolder::~SessionFolder() {
  if (is_new_ && IsEmpty()) RemoveAll();
  if (lock_ >= 0) close(lock_);
}

bool SessionFolder::IsEmpty() const {
  return std::all_of(
      cameras_.begin(), cameras_.end(),
      [](const Session& session) { return session.frames.empty(); });
}

// Keeps other files, and folders that contain any.
void SessionFolder::RemoveAll() const {
  std::error_code error;
  const fs::path frames = fs::path(folder_) / kSessionFrames;
  for (const Session& session : cameras_)
    if (!session.camera.empty()) fs::remove(frames / session.camera, error);
  if (has_made_pattern_) fs::remove(fs::path(folder_) / kSessionPattern, error);
  for (const char* name : {kSessionFile, kSessionFrames, ""})
    fs::remove(fs::path(folder_) / name, error);
}

std::vector<std::string> SessionFolder::CollectFrameSets() const {
  // The first camera's frames in their order; frames of other cameras are
  // inserted between them.
  std::vector<std::string> names;
  for (const Session& session : cameras_) {
    auto at = names.begin();
    for (const SessionFrame& frame : session.frames) {
      const auto found = std::find(names.begin(), names.end(), frame.image);
      at = found != names.end() ? found + 1 : names.insert(at, frame.image) + 1;
    }
  }
  return names;
}

std::string SessionFolder::MakePath(size_t camera,
                                    const std::string& image) const {
  return SessionFramePath(folder_, cameras_[camera].camera, image);
}

std::string SessionFolder::NewName(const std::string& photograph) {
  const auto is_taken = [this](const std::string& name) {
    for (size_t c = 0; c < cameras_.size(); ++c) {
      std::error_code error;
      if (fs::exists(MakePath(c, name), error)) return true;
    }
    return false;
  };
  if (!photograph.empty() && !is_taken(photograph)) return photograph;
  std::string name;
  do name = fmt::format("frame-{:04d}.png", ++number_);
  while (is_taken(name));
  return name;
}

void SessionFolder::Save(std::vector<FrameToSave> frames) {
  for (FrameToSave& frame : frames)
    WriteFile(MakePath(frame.camera, frame.record.image),
              std::move(frame.bytes));
  for (const FrameToSave& frame : frames) {
    Session& session = cameras_[frame.camera];
    if (session.frames.empty()) session.image_size = frame.size;
    session.frames.push_back(frame.record);
  }
  Write();
}

void SessionFolder::Remove(const std::string& image) {
  std::vector<std::string> paths;
  for (size_t c = 0; c < cameras_.size(); ++c) {
    auto& frames = cameras_[c].frames;
    const auto found = std::find_if(
        frames.begin(), frames.end(),
        [&image](const SessionFrame& frame) { return frame.image == image; });
    if (found == frames.end()) continue;
    frames.erase(found);
    paths.push_back(MakePath(c, image));
  }
  if (paths.empty()) return;
  Write();
  std::error_code error;
  for (const std::string& path : paths) fs::remove(path, error);
}

void SessionFolder::RecordLocked(size_t camera,
                                 const std::vector<std::string>& locked,
                                 const std::vector<std::string>& not_locked) {
  cameras_[camera].locked = locked;
  cameras_[camera].not_locked = not_locked;
  Write();
}

void SessionFolder::Write() {
  WriteFile((fs::path(folder_) / kSessionFile).string(),
            FormatSession(cameras_));
}

}  // namespace raygrid
