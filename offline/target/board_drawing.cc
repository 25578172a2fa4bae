#include "target/board_drawing.h"

#include "dataset/error.h"

namespace raygrid {

void DrawBoard(const BoardAppearance& appearance, const Eigen::Vector2d& corner,
               double units_per_m, cairo_t* cr) {
  const Area& extent_m = appearance.extent_m();
  cairo_save(cr);
  cairo_translate(cr, corner.x(), corner.y());
  cairo_scale(cr, units_per_m, units_per_m);
  cairo_translate(cr, -extent_m.x0, -extent_m.y0);
  for (const InkLayer& layer : appearance.Layers()) {
    for (const Polygon& polygon : layer.polygons) {
      cairo_new_sub_path(cr);
      for (const Eigen::Vector2d& p : polygon) cairo_line_to(cr, p.x(), p.y());
      cairo_close_path(cr);
    }
    const double brightness = layer.is_black ? 0 : 1;
    cairo_set_source_rgb(cr, brightness, brightness, brightness);
    cairo_fill(cr);
  }
  cairo_restore(cr);
}

cairo_status_t AppendBytes(void* text, const unsigned char* data,
                           unsigned int length) {
  static_cast<std::string*>(text)->append(reinterpret_cast<const char*>(data),
                                          length);
  return CAIRO_STATUS_SUCCESS;
}

void FinishSurface(cairo_surface_t* surface) {
  cairo_surface_finish(surface);
  const cairo_status_t status = cairo_surface_status(surface);
  cairo_surface_destroy(surface);
  if (status != CAIRO_STATUS_SUCCESS)
    throw Error(ExitCode::kOutputFailed, cairo_status_to_string(status));
}

std::string RenderPng(int width, int height,
                      const std::function<void(cairo_t*)>& draw) {
  cairo_surface_t* surface =
      cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height);
  cairo_t* cr = cairo_create(surface);
  draw(cr);
  cairo_destroy(cr);
  std::string png;
  const cairo_status_t status =
      cairo_surface_write_to_png_stream(surface, AppendBytes, &png);
  FinishSurface(surface);
  if (status != CAIRO_STATUS_SUCCESS)
    throw Error(ExitCode::kOutputFailed, cairo_status_to_string(status));
  return png;
}

}  // namespace raygrid
