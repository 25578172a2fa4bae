#ifndef RAYGRID_APPEARANCE_MARKER_BITS_H
#define RAYGRID_APPEARANCE_MARKER_BITS_H

#include <string>
#include <vector>

namespace raygrid {

/// The cells of a marker, row by row.
struct MarkerBits {
  int size = 0;
  std::vector<bool> is_black;

  bool at(int column, int row) const { return is_black[row * size + column]; }
};

/// Returns an AprilTag with its white margin of one cell: 10 x 10 cells for
/// tag36h11. Families are tag36h11, tag25h9 and tag16h5. Throws InputError for
/// other families, and for IDs that the family does not have.
MarkerBits AprilTagBits(const std::string& family, int id);

/// Returns an ArUco marker with its black border of one cell. The dictionary is
/// named as in OpenCV, "DICT_4X4_50". Throws InputError if it is unknown.
MarkerBits ArucoBits(const std::string& dictionary, int id);

}  // namespace raygrid

#endif  // RAYGRID_APPEARANCE_MARKER_BITS_H
