/// Drawing of boards with cairo, and output of cairo's surfaces.
#ifndef RAYGRID_TARGET_BOARD_DRAWING_H
#define RAYGRID_TARGET_BOARD_DRAWING_H

#include <cairo.h>

#include <functional>
#include <string>

#include "appearance/board_appearance.h"

namespace raygrid {

/// Draws the ink, with the board's top-left extent at `corner` on the page. The
/// squares of a layer are filled as one path, to avoid seams between them.
void DrawBoard(const BoardAppearance& appearance, const Eigen::Vector2d& corner,
               double units_per_m, cairo_t* cr);

/// Callback for cairo surfaces: appends bytes to the std::string `text`.
cairo_status_t AppendBytes(void* text, const unsigned char* data,
                           unsigned int length);

/// Finishes and destroys the surface. Throws Error(kOutputFailed).
void FinishSurface(cairo_surface_t* surface);

/// Draws a PNG of width x height pixels and returns its bytes.
std::string RenderPng(int width, int height,
                      const std::function<void(cairo_t*)>& draw);

}  // namespace raygrid

#endif  // RAYGRID_TARGET_BOARD_DRAWING_H
