#ifndef RAYGRID_CAPTURE_SESSION_FOLDER_H
#define RAYGRID_CAPTURE_SESSION_FOLDER_H

#include <string>
#include <vector>

#include "dataset/pattern.h"
#include "session_file.h"

namespace raygrid {

/// A camera's frame of an instant, to be kept.
struct KeptFrame {
  size_t camera = 0;
  ImageSize size;
  SessionFrame record;  ///< with the instant's name as its image
  std::string bytes;    ///< of the image's file
};

/// The folder of a live capture: frames/, session.json and pattern.yaml. Each
/// file appears whole or not at all. session.json names the frames of an
/// instant once all their images are there, so that a program that is killed
/// loses none. Nobody else may write to it meanwhile.
class SessionFolder {
 public:
  /// Makes a session, or goes on with the folder's own. cameras are the names
  /// of a rig's, or one that is empty. Throws Error: the folder has a session
  /// and none is to be resumed, or the other way round, or one of another
  /// pattern or other cameras, or a pattern.yaml of another target; another
  /// program writes to it; it cannot be written.
  SessionFolder(const std::string& folder, const Pattern& pattern,
                const std::vector<std::string>& cameras, bool resume);
  /// Removes a session that was made and kept no frame.
  ~SessionFolder();
  SessionFolder(const SessionFolder&) = delete;
  SessionFolder& operator=(const SessionFolder&) = delete;

  const std::vector<Session>& cameras() const { return cameras_; }
  /// The names of all instants, the oldest first.
  std::vector<std::string> CollectFrameSets() const;
  /// The file of a frame, there or not.
  std::string PathOf(size_t camera, const std::string& image) const;

  /// A name that no instant has: frame-0001.png and so on, or a photograph's
  /// own.
  std::string NewName(const std::string& photograph);
  /// Adds the frames of an instant. Throws Error(kOutput); the instants before
  /// stay.
  void Save(std::vector<KeptFrame> frames);
  void Remove(const std::string& image);
  void RecordLocked(size_t camera, const std::vector<std::string>& locked,
                    const std::vector<std::string>& not_locked);

 private:
  void Write();
  void TakePattern(const std::string& path, const std::string& text);
  bool IsEmpty() const;
  void RemoveAll() const;

  std::string folder_;
  std::vector<Session> cameras_;
  int number_ = 0;  // of the last name
  int lock_ = -1;
  bool is_new_ = false, has_made_pattern_ = false;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_SESSION_FOLDER_H
