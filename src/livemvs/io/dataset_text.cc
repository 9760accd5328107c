#include "livemvs/io/dataset_text.h"

#include <charconv>
#include <cmath>
#include <fstream>

#include "livemvs/core/error.h"

namespace livemvs {
namespace {

constexpr std::string_view kBlanks = " \t\r\n\v\f";

}  // namespace

std::string Place(const std::filesystem::path& path, std::size_t line) {
  return line == 0 ? path.string() : path.string() + ":" + std::to_string(line);
}

std::string ReadTextFile(const std::filesystem::path& path, std::size_t max_bytes) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) {
    throw BadInput(path.string() + ": no such file");
  }
  if (!std::filesystem::is_regular_file(status)) {
    throw BadInput(path.string() + ": not a regular file; a text file is needed here");
  }
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) throw BadInput(path.string() + ": cannot be read: " + error.message());
  if (size == 0) throw BadInput(path.string() + ": the file is empty");
  if (size > max_bytes) {
    throw BadInput(path.string() + ": " + std::to_string(size) + " bytes, more than the " +
                   std::to_string(max_bytes) + " that such a file may have; is it the right file?");
  }
  std::ifstream stream(path, std::ios::binary);
  std::string text(static_cast<std::size_t>(size), '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!stream) throw BadInput(path.string() + ": cannot be read");
  if (text.find('\0') != std::string::npos) {
    throw BadInput(path.string() +
                   ": not a text file (it holds zero bytes); is it the right file?");
  }
  return text;
}

std::optional<std::string_view> LineReader::Next() {
  if (rest_.empty()) return std::nullopt;
  const std::size_t end = rest_.find('\n');
  std::string_view line = rest_.substr(0, end);
  rest_ = end == std::string_view::npos ? std::string_view{} : rest_.substr(end + 1);
  ++line_;
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

std::optional<std::string_view> LineReader::NextContent() {
  while (const std::optional<std::string_view> line = Next()) {
    const std::string_view content = Trim(*line);
    if (!content.empty() && content.front() != '#') return content;
  }
  return std::nullopt;
}

std::string_view Trim(std::string_view s) {
  const std::size_t first = s.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return s.substr(first, s.find_last_not_of(kBlanks) - first + 1);
}

std::vector<std::string_view> SplitWords(std::string_view line, std::string_view also) {
  const std::string separators = std::string(kBlanks) + std::string(also);
  std::vector<std::string_view> words;
  std::size_t first = line.find_first_not_of(separators);
  while (first != std::string_view::npos) {
    const std::size_t end = line.find_first_of(separators, first);
    words.push_back(line.substr(first, end == std::string_view::npos ? end : end - first));
    first = line.find_first_not_of(separators, end);
  }
  return words;
}

std::string Shortened(std::string_view word, std::size_t longest) {
  std::string s(word.substr(0, longest));
  for (char& c : s) {
    if (c < 0x20 || c > 0x7e) c = '?';
  }
  return word.size() > longest ? s + "..." : s;
}

std::string ToLower(std::string_view s) {
  std::string lower(s);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

std::optional<double> ParseNumber(std::string_view word) {
  if (word.size() > 1 && word.front() == '+' && word[1] != '-') word.remove_prefix(1);
  double value = 0;
  const std::from_chars_result result =
      std::from_chars(word.data(), word.data() + word.size(), value);
  if (result.ptr != word.data() + word.size() || word.empty()) return std::nullopt;
  // Too small for a double is zero; too large is not finite, which callers reject.
  if (result.ec == std::errc::result_out_of_range) {
    const bool tiny =
        word.find("e-") != std::string_view::npos || word.find("E-") != std::string_view::npos;
    return tiny ? 0.0 : HUGE_VAL;
  }
  if (result.ec != std::errc{}) return std::nullopt;
  return value;
}

double FiniteNumber(std::string_view word, const std::string& place, const std::string& what) {
  const std::optional<double> value = ParseNumber(word);
  if (!value || !std::isfinite(*value)) {
    throw BadInput(place + ": '" + Shortened(word) + "' is not a finite number (" + what + ")");
  }
  return *value;
}

std::vector<double> FiniteNumbers(const std::vector<std::string_view>& words,
                                  const std::string& place,
                                  const std::string& what) {
  std::vector<double> values;
  values.reserve(words.size());
  for (const std::string_view word : words) values.push_back(FiniteNumber(word, place, what));
  return values;
}

}  // namespace livemvs
