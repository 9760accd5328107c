#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace livemvs {

/// Text files of poses and calibrations larger than this are refused. [bytes]
inline constexpr std::size_t kMaxTextBytes = std::size_t{256} << 20;

/// "path:line" (or "path" where the line is 0), the way every message on a text file begins.
std::string Place(const std::filesystem::path& path, std::size_t line);

/// The whole of a text file.
/// @throws Error (kBadInput) where it is missing, empty, no regular file, larger than `max_bytes`,
/// or holds zero bytes (it is then no text).
std::string ReadTextFile(const std::filesystem::path& path, std::size_t max_bytes = kMaxTextBytes);

/// Lines of a text, one after the other, without line ends ("\n" or "\r\n"). The text must outlive
/// it.
class LineReader {
 public:
  explicit LineReader(std::string_view text) : rest_(text) {}

  /// The next line, or nothing at the end.
  std::optional<std::string_view> Next();
  /// The next line that is neither blank nor a comment (first character '#'), without the blanks
  /// around it.
  std::optional<std::string_view> NextContent();
  /// Number of the line that was read last, from 1.
  std::size_t line() const { return line_; }

 private:
  std::string_view rest_;
  std::size_t line_ = 0;
};

/// Without blanks at both ends.
std::string_view Trim(std::string_view s);

/// The words of a line; separated by blanks, tabs and any character of `also`.
std::vector<std::string_view> SplitWords(std::string_view line, std::string_view also = {});

/// The beginning of what a file says, for messages: what hostile files hold must neither flood the
/// terminal nor command it. Anything but printable ASCII becomes '?'.
std::string Shortened(std::string_view word, std::size_t longest = 40);

/// In lower case (ASCII).
std::string ToLower(std::string_view s);

/// The word as a number, whatever the locale; NaN and infinities are numbers here. Nothing where
/// any part of the word is left over.
std::optional<double> ParseNumber(std::string_view word);

/// A word that must be a finite number.
/// @throws Error (kBadInput): "place: 'word' is not a finite number (what)".
double FiniteNumber(std::string_view word, const std::string& place, const std::string& what);

/// All the words must be finite numbers.
std::vector<double> FiniteNumbers(const std::vector<std::string_view>& words,
                                  const std::string& place,
                                  const std::string& what);

}  // namespace livemvs
