#ifndef RAYGRID_EXCHANGE_FILE_STORAGE_H
#define RAYGRID_EXCHANGE_FILE_STORAGE_H

#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

namespace raygrid {

/// A text of OpenCV's FileStorage as a tree, whichever of YAML, XML and JSON it
/// is. A matrix is a map of rows, cols, dt and data. Throws InputError, and
/// what yaml-cpp throws; path is used in errors.
YAML::Node ParseFileStorage(const std::string& path, const std::string& text);

/// Whether a text has a matrix as FileStorage writes them, of two axes or more.
bool IsFileStorage(const std::string& text);

/// A matrix, row by row, of one channel or several.
struct StoredMatrix {
  int rows = 0, columns = 0;
  std::vector<double> data;
};

/// A matrix of FileStorage, or the lists that Python has instead. Throws
/// InputError, naming the matrix, also if its number of channels differs.
StoredMatrix ParseStoredMatrix(const YAML::Node& node, const std::string& name,
                               int num_channels = 1);

/// Points of two numbers, of images row by row: a matrix of two channels, or an
/// array of more axes, as numpy has lists of them. Throws InputError, naming
/// it.
StoredMatrix ParseStoredPoints(const YAML::Node& node, const std::string& name);

/// Writes what FileStorage reads.
class FileStorageText {
 public:
  enum class Kind { kYaml, kXml, kJson };
  /// The kind that a file's name ends with; YAML if it ends otherwise.
  static Kind KindOf(const std::string& path);

  explicit FileStorageText(Kind kind);

  void Add(const std::string& key, int number);
  void Add(const std::string& key, double number);
  void Add(const std::string& key, const std::string& text);
  void Add(const std::string& key, const StoredMatrix& matrix);
  void Add(const std::string& key, const std::vector<std::string>& texts);
  void BeginMap(const std::string& key);
  void EndMap();
  std::string Finish();

 private:
  void AddPlain(const std::string& key, const std::string& value);
  std::string Indentation() const;

  Kind kind_;
  std::string text_;
  std::vector<std::string> open_;  // keys of maps
};

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_FILE_STORAGE_H
