#ifndef RAYGRID_TESTS_SUPPORT_TEMPORARY_FOLDER_H
#define RAYGRID_TESTS_SUPPORT_TEMPORARY_FOLDER_H

#include <stdlib.h>

#include <filesystem>
#include <string>

namespace raygrid {

/// A folder that lives as long as the test. No other has its name, so tests of
/// several builds may run at once.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name =
        (std::filesystem::temp_directory_path() / "raygrid-XXXXXX").string();
    if (mkdtemp(name.data())) path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::string operator/(const std::string& name) const {
    return (std::filesystem::path(path_) / name).string();
  }
  /// How many entries it has.
  int Count() const {
    int count = 0;
    for ([[maybe_unused]] const auto& entry :
         std::filesystem::directory_iterator(path_))
      ++count;
    return count;
  }

 private:
  std::string path_;
};

}  // namespace raygrid

#endif  // RAYGRID_TESTS_SUPPORT_TEMPORARY_FOLDER_H
