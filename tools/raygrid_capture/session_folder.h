#ifndef RAYGRID_CAPTURE_SESSION_FOLDER_H
#define RAYGRID_CAPTURE_SESSION_FOLDER_H

#include <string>
#include <vector>

#include "dataset/pattern.h"
#include "session_file.h"

namespace raygrid {

/// A camera's image of a frame set, to be kept.
struct FrameToSave {
  size_t camera = 0;
  ImageSize size;
  SessionFrame record;  ///< `image` contains the name of the frame set
  std::string bytes;    ///< contents of the image file
};

/// The folder of a live capture: frames/, session.json and pattern.yaml. Each
/// file is written completely or not at all. A frame set is listed in
/// session.json after all its images are written, so that killing the program
/// loses none. Locked against other programs.
class SessionFolder {
 public:
  /// Creates a session, or resumes that of the folder. cameras: names in a rig,
  /// or one empty name. Throws Error if a session exists and resume is false,
  /// or vice versa; if its pattern, cameras or pattern.yaml differ; if another
  /// program writes to the folder; or if it is not writable.
  SessionFolder(const std::string& folder, const Pattern& pattern,
                const std::vector<std::string>& cameras, bool resume);
  /// Removes a new session without frames.
  ~SessionFolder();
  SessionFolder(const SessionFolder&) = delete;
  SessionFolder& operator=(const SessionFolder&) = delete;

  const std::vector<Session>& cameras() const { return cameras_; }
  /// Returns the names of all frame sets, oldest first.
  std::vector<std::string> CollectFrameSets() const;
  /// Returns the path of an image, which need not exist.
  std::string MakePath(size_t camera, const std::string& image) const;

  /// Returns an unused frame name: frame-0001.png and so on, or the name of the
  /// photograph.
  std::string NewName(const std::string& photograph);
  /// Adds a frame set. Throws Error(kOutputFailed); earlier frame sets are not
  /// affected.
  void Save(std::vector<FrameToSave> frames);
  void Remove(const std::string& image);
  void RecordLocked(size_t camera, const std::vector<std::string>& locked,
                    const std::vector<std::string>& not_locked);

 private:
  void Write();
  void AdoptPattern(const std::string& path, const std::string& text);
  bool IsEmpty() const;
  void RemoveAll() const;

  std::string folder_;
  std::vector<Session> cameras_;
  int number_ = 0;  // number in the last name
  int lock_ = -1;
  bool is_new_ = false, has_made_pattern_ = false;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_SESSION_FOLDER_H
