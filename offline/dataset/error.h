#ifndef RAYGRID_DATASET_ERROR_H
#define RAYGRID_DATASET_ERROR_H

#include <stdexcept>
#include <string>

namespace raygrid {

/// Exit codes of the programs.
enum class ExitCode {
  kDone = 0,
  kUsage = 1,
  kInvalidInput = 2,          ///< an input is unreadable or malformed
  kInsufficientData = 3,      ///< too few features or images
  kInitializationFailed = 4,  ///< initialization failed
  kNotConverged = 5,
  kQualityTooLow = 6,  ///< a quality gate failed
  kOutputFailed = 7,   ///< an output could not be written
  kInvalidBlob = 8     ///< a blob is corrupt, unsupported or does not match
};

/// An error that ends a command: one line with what failed, where, and the
/// remedy.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message)
      : std::runtime_error(message), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

class InputError : public Error {
 public:
  explicit InputError(const std::string& message)
      : Error(ExitCode::kInvalidInput, message) {}
};

}  // namespace raygrid

#endif  // RAYGRID_DATASET_ERROR_H
