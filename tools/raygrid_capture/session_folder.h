#ifndef RAYGRID_CAPTURE_SESSION_FOLDER_H
#define RAYGRID_CAPTURE_SESSION_FOLDER_H

#include <string>

#include "dataset/pattern.h"
#include "session_file.h"

namespace raygrid {

/// The folder of a live capture: frames/, session.json and pattern.yaml. Each
/// file appears whole or not at all. session.json names a frame once its image
/// is there, so that a program that is killed loses none. Nobody else may write
/// to it meanwhile.
class SessionFolder {
 public:
  /// Makes a session, or goes on with the folder's own. Throws Error: the
  /// folder has a session and none is to be resumed, or the other way round, or
  /// another pattern; another program writes to it; it cannot be written.
  SessionFolder(const std::string& folder, const Pattern& pattern, bool resume);
  /// Removes a session that was made and kept no frame.
  ~SessionFolder();
  SessionFolder(const SessionFolder&) = delete;
  SessionFolder& operator=(const SessionFolder&) = delete;

  const Session& session() const { return session_; }
  const std::string& folder() const { return folder_; }
  std::string PathOf(const std::string& image) const;

  /// A name that no frame has: frame-0001.png and so on, or a photograph's own.
  std::string NewName(const std::string& photograph);
  /// Adds a frame with the bytes of its file. Throws Error(kOutput); the
  /// frames before stay.
  void Keep(const ImageSize& size, const SessionFrame& frame,
            std::string image_bytes);
  void Remove(const std::string& image);
  void NoteLocked(const std::vector<std::string>& locked,
                  const std::vector<std::string>& not_locked);

 private:
  void Write();
  void RemoveAll() const;

  std::string folder_;
  Session session_;
  int number_ = 0;  // of the last name
  int lock_ = -1;
  bool is_new_ = false;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_SESSION_FOLDER_H
