#pragma once

#include <stdexcept>
#include <string>

namespace livemvs {

/// What kind of failure an Error reports; the program maps it to its exit code.
enum class ErrorKind {
  kFailed,        ///< Something went wrong that is neither the input's nor the machine's fault.
  kBadInput,      ///< A file or stream is missing, broken or inconsistent.
  kOutOfResource  ///< Memory, disk or device exhausted, or an output that cannot be written.
};

/// A failure outside of our control (file, codec, device). The message names the path or device,
/// the place in it, and what to do. Wrong arguments throw std::invalid_argument instead.
class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}

  ErrorKind kind() const { return kind_; }

 private:
  ErrorKind kind_;
};

/// Shorthand for the most common kind.
inline Error BadInput(const std::string& message) { return Error(ErrorKind::kBadInput, message); }

}  // namespace livemvs
