/// Damaged files, and what may come of them: one line, or numbers.
#ifndef RAYGRID_TESTS_OFFLINE_EXCHANGE_DAMAGED_FILES_H
#define RAYGRID_TESTS_OFFLINE_EXCHANGE_DAMAGED_FILES_H

#include <cstdlib>
#include <string>

#include "exchange/format.h"
#include "support.h"

namespace raygrid {

/// A file with bytes changed, cut, doubled, or with numbers that are none.
inline std::string Mutated(std::string text, TestRandom* random) {
  static const char* const numbers[] = {".nan", "-.inf", "1e999", "nan", "-1",
                                        "0",    "1e300", "[]",    "''",  "~"};
  const int kind = random->Index(5);
  if (kind == 0) return text.substr(0, random->Index(1 + (int)text.size()));
  if (kind == 1) {
    const size_t from = random->Index(static_cast<int>(text.size()));
    return text.insert(from, text.substr(from, random->Index(200)));
  }
  if (kind == 2) {
    size_t at = random->Index(static_cast<int>(text.size()));
    at = text.find_first_of("0123456789", at);
    if (at == std::string::npos) return text;
    const size_t end = text.find_first_not_of("0123456789.e+-", at);
    return text.replace(at, end == std::string::npos ? end : end - at,
                        numbers[random->Index(10)]);
  }
  const int count = kind == 3 ? 1 : 10;
  for (int k = 0; k < count; ++k)
    text[random->Index(static_cast<int>(text.size()))] =
        static_cast<char>(random->Index(256));
  return text;
}

/// How many damaged files are read: RAYGRID_MUTANTS, or so many.
inline int NumMutants(int usual) {
  const char* const count = std::getenv("RAYGRID_MUTANTS");
  return count ? std::atoi(count) : usual;
}

/// All numbers of contents are numbers.
inline void ExpectFinite(const std::vector<ImageFeatures>& images) {
  for (const ImageFeatures& image : images)
    for (const Feature& feature : image.features)
      EXPECT_TRUE(feature.pixel.allFinite()) << image.image;
}
inline void ExpectFinite(const ExchangeContents& contents) {
  ExpectFinite(contents.corners);
  for (const Board& board : contents.boards) {
    EXPECT_TRUE(std::isfinite(board.square_m + board.spacing_ratio));
    for (const Eigen::Vector3d& point : board.points)
      EXPECT_TRUE(point.allFinite());
  }
  for (const InputCamera& camera : contents.cameras) {
    EXPECT_TRUE(MakeCameraFile(camera).camera->Parameters().allFinite());
    ExpectFinite(camera.features);
    for (const BoardPose& pose : camera.poses)
      EXPECT_TRUE(pose.camera_from_board.rotation.coeffs().allFinite() &&
                  pose.camera_from_board.translation.allFinite());
  }
}

/// Whether read(), which expects what it likes of a file, refuses a damaged
/// one; it must do so with one line.
template <typename Read>
bool IsRefused(const Read& read) {
  try {
    read();
    return false;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInvalidInput) << error.what();
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    return true;
  }
}

}  // namespace raygrid

#endif  // RAYGRID_TESTS_OFFLINE_EXCHANGE_DAMAGED_FILES_H
