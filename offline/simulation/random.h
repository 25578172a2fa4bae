#ifndef RAYGRID_SIMULATION_RANDOM_H
#define RAYGRID_SIMULATION_RANDOM_H

#include <cmath>
#include <cstdint>
#include <random>

namespace raygrid {

/// Uniform and normal random numbers, independent of the standard library's
/// implementation.
class Random {
 public:
  explicit Random(uint64_t seed) : engine_(seed) {}

  double Uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  /// Box-Muller transform.
  double Normal() {
    const double radius = std::sqrt(-2 * std::log(1 - Uniform(0, 1)));
    return radius * std::cos(Uniform(0, 2 * M_PI));
  }
  int Index(int count) { return static_cast<int>(Uniform(0, count)); }

 private:
  std::mt19937_64 engine_;
};

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_RANDOM_H
