/// Boards drawn with cairo, and what cairo drew as the bytes of a file.
#ifndef RAYGRID_TARGET_BOARD_DRAWING_H
#define RAYGRID_TARGET_BOARD_DRAWING_H

#include <cairo.h>

#include <functional>
#include <string>

#include "appearance/board_appearance.h"

namespace raygrid {

/// The ink, with the board's extent at a place on the page. The squares of a
/// layer are filled as one path: no seams where they touch.
void DrawBoard(const BoardAppearance& appearance, const Eigen::Vector2d& corner,
               double units_per_m, cairo_t* cr);

/// Appends bytes to a std::string, for cairo's surfaces that write to one.
cairo_status_t AppendBytes(void* text, const unsigned char* data,
                           unsigned int length);

/// Writes what is left, and frees the surface; throws Error(kOutput).
void FinishSurface(cairo_surface_t* surface);

/// A picture of width x height pixels.
std::string DrawnPng(int width, int height,
                     const std::function<void(cairo_t*)>& draw);

}  // namespace raygrid

#endif  // RAYGRID_TARGET_BOARD_DRAWING_H
