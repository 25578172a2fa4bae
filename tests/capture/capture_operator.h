#ifndef RAYGRID_TESTS_CAPTURE_CAPTURE_OPERATOR_H
#define RAYGRID_TESTS_CAPTURE_CAPTURE_OPERATOR_H

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "camera/camera_model.h"
#include "dataset/pattern.h"
#include "http_client.h"
#include "simulation/board_surface.h"
#include "simulation/image_rendering.h"
#include "simulation/random.h"

namespace raygrid {

/// The next state that a capture's page tells by the stream GET /state; nothing
/// where the stream ends.
std::optional<nlohmann::json> NextState(HttpClient* page);

/// A person before a camera, who looks at the page and holds the board where
/// its outline is, a centimetre and two degrees off. The camera's images are
/// rendered.
class CaptureOperator {
 public:
  /// patience  states in which a view is not kept, before the person holds the
  ///           board anew
  CaptureOperator(const CameraModel& camera, const Board& board, int patience);

  /// Looks at a state. Returns the grey levels that the camera sees from now
  /// on, row by row; nothing while the board stays where it is.
  std::optional<std::vector<uint8_t>> Look(const nlohmann::json& state);

  bool is_done() const { return is_done_; }
  size_t num_kept() const { return num_kept_; }
  int num_views() const { return num_views_; }

 private:
  std::optional<std::vector<uint8_t>> Fill(const nlohmann::json& outline);

  const CameraModel& camera_;
  const Board board_;
  const BoardSurface surface_;
  const PixelRays rays_;
  const int patience_;
  Random random_{11};
  size_t num_kept_ = 0;
  int num_views_ = 0, num_looks_ = 0;
  bool is_done_ = false;
  nlohmann::json filled_;  // outline
};

}  // namespace raygrid

#endif  // RAYGRID_TESTS_CAPTURE_CAPTURE_OPERATOR_H
