// Hostile bytes as the description of a board. What is read is a board that can be printed, and is
// read again as it is written.

#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "file_input.h"
#include "livemvs/core/error.h"
#include "livemvs/tracking/board.h"

namespace {

using namespace livemvs;

void Require(bool condition) {
  if (!condition) std::abort();
}

std::optional<Board> Read(std::span<const std::uint8_t> bytes) {
  try {
    const FileInput file(bytes);
    return ReadBoard(file.path());
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::optional<Board> board = Read({data, size});
  if (!board) return 0;
  board->Check();
  Require(!MarkersOf(*board).empty() && CornersOf(*board).size() >= 8);
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("board_fuzz_" + std::to_string(::getpid()));
  WriteBoard(path, *board);
  const Board again = ReadBoard(path);
  std::filesystem::remove(path);
  Require(again.square == board->square && again.marker == board->marker);
  Require(again.columns == board->columns && again.rows == board->rows);
  Require(again.plain.has_value() == board->plain.has_value());
  return 0;
}
