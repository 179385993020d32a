// The one exception type of cylpose. Its text names the file or option, the value and the remedy.
#pragma once

#include <stdexcept>
#include <string>

namespace cylpose {

/// What kind of thing went wrong; decides the exit code of the `cylpose` command.
enum class ErrorKind {
  kInput,   ///< a file, an option or an image that cannot be used as it is
  kOutput,  ///< a result that cannot be written
  kDevice,  ///< a camera or compute device that is missing or failed
};

class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}
  [[nodiscard]] ErrorKind kind() const noexcept { return kind_; }

 private:
  ErrorKind kind_;
};

}  // namespace cylpose
