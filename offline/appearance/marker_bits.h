#ifndef RAYGRID_APPEARANCE_MARKER_BITS_H
#define RAYGRID_APPEARANCE_MARKER_BITS_H

#include <string>
#include <vector>

namespace raygrid {

/// A marker's cells, row by row.
struct MarkerBits {
  int size = 0;
  std::vector<bool> is_black;

  bool at(int column, int row) const { return is_black[row * size + column]; }
};

/// An AprilTag with its white margin of one cell: 10 x 10 cells of tag36h11.
/// Families are tag36h11, tag25h9 and tag16h5. Throws InputError for others,
/// and for numbers that the family does not have.
MarkerBits AprilTagBits(const std::string& family, int id);

/// An ArUco marker with its black border of one cell. The dictionary is named
/// as in OpenCV, "DICT_4X4_50"; throws InputError.
MarkerBits ArucoBits(const std::string& dictionary, int id);

}  // namespace raygrid

#endif  // RAYGRID_APPEARANCE_MARKER_BITS_H
