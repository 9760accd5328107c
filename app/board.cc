// livemvs board: writes a sheet to print, and its description.

#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "commands.h"
#include "livemvs/io/picture_codec.h"
#include "livemvs/tracking/board.h"
#include "livemvs/tracking/board_sheet.h"
#include "output_check.h"

namespace livemvs::app {
namespace {

namespace fs = std::filesystem;

struct BoardArguments {
  fs::path output, pdf, png;
  std::string page = "A4";
  std::string squares, plain;
  double square_mm = 0, marker_mm = 0;
  std::string dictionary;
  int first_id = 0;
  bool top_left_white = false;
  double dpi = 300;
};

// "12x8".
void ParsePair(const std::string& option, const std::string& text, int* a, int* b) {
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", a, b, &rest) != 2) {
    throw std::invalid_argument(option + " " + text + ": must be COLUMNSxROWS");
  }
}

// A plain area in the middle, as far as whole squares allow.
PlainArea PlainInTheMiddle(const BoardArguments& a, const Board& board) {
  PlainArea plain;
  ParsePair("--plain", a.plain, &plain.columns, &plain.rows);
  if (plain.columns < 1 || plain.rows < 1 || plain.columns > board.columns ||
      plain.rows > board.rows) {
    throw std::invalid_argument("--plain " + a.plain + ": must be squares within the board");
  }
  plain.column = (board.columns - plain.columns) / 2;
  plain.row = (board.rows - plain.rows) / 2;
  return plain;
}

Board BoardOf(const BoardArguments& a) {
  Board board = BoardForPage(a.page);
  if (!a.squares.empty()) ParsePair("--squares", a.squares, &board.columns, &board.rows);
  if (a.square_mm != 0) {
    board.marker *= a.square_mm / 1000 / board.square;
    board.square = a.square_mm / 1000;
  }
  if (a.marker_mm != 0) board.marker = a.marker_mm / 1000;
  if (!a.dictionary.empty()) board.dictionary = a.dictionary;
  board.first_id = a.first_id;
  board.top_left_black = !a.top_left_white;
  board.Check();
  if (!a.plain.empty()) board.plain = PlainInTheMiddle(a, board);
  board.Check();
  return board;
}

void RunBoard(const BoardArguments& a) {
  CheckOutputs({{a.output, "the description", "a description of a board", "{"},
                {a.pdf, "the PDF", "a PDF", "%PDF"},
                {a.png, "the picture", "a PNG", "\x89PNG"}},
               {});
  const Board board = BoardOf(a);
  const Page page = PageByName(a.page, board);
  if (!a.pdf.empty()) WriteSheetPdf(a.pdf, board, page);
  if (!a.png.empty()) WritePng(a.png, DrawSheet(board, page, a.dpi));
  WriteBoard(a.output, board);
  std::printf("%d x %d squares of %.6g mm, %zu corners, %zu markers of %.6g mm from %s\n",
              board.columns,
              board.rows,
              1e3 * board.square,
              CornersOf(board).size(),
              MarkersOf(board).size(),
              1e3 * board.marker,
              board.dictionary.c_str());
  std::printf("%s\n", a.output.c_str());
  if (!a.pdf.empty()) std::printf("%s: print at 100 %% and check the ruler\n", a.pdf.c_str());
  if (!a.png.empty()) std::printf("%s\n", a.png.c_str());
}

}  // namespace

void AddBoardCommand(CLI::App& app) {
  auto a = std::make_shared<BoardArguments>();
  CLI::App* command = app.add_subcommand(
      "board", "Make a sheet to print, on which objects are filmed, and its description");
  command->add_option("-o,--output", a->output, "Description to write (.json)")->required();
  command->add_option("--pdf", a->pdf, "Sheet to write as PDF");
  command->add_option("--png", a->png, "Sheet to write as picture");
  command->add_option("--page", a->page, "A4, A3, Letter (all landscape) or fit")
      ->capture_default_str();
  command->add_option("--squares", a->squares, "COLUMNSxROWS; default 12x8");
  command->add_option("--square-mm", a->square_mm, "Side of a square; default: fills the page");
  command->add_option(
      "--marker-mm", a->marker_mm, "Side of a marker; default: about three quarters of it");
  command->add_option("--dictionary", a->dictionary, "OpenCV's name; default DICT_4X4_250");
  command->add_option("--first-id", a->first_id, "Code of the first marker");
  command->add_flag("--top-left-white", a->top_left_white, "Start with a white square");
  command->add_option("--plain", a->plain, "COLUMNSxROWS of squares in the middle to leave white");
  command->add_option("--dpi", a->dpi, "Of the picture")->capture_default_str();
  command->footer(
      "Print at 100 % (no 'fit to page'), check that the line below the board is 100 mm long, and "
      "glue\nthe sheet to something flat. Where the line is not 100 mm long, make the description "
      "anew "
      "with\n--square-mm and --marker-mm as measured.\n\n"
      "Examples:\n"
      "  livemvs board -o board.json --pdf board.pdf\n"
      "  livemvs board -o board.json --pdf board.pdf --page A3 --plain 4x2\n"
      "  livemvs board -o board.json --page fit --squares 12x8 --square-mm 35 --marker-mm 26");
  command->callback([a] { RunBoard(*a); });
}

}  // namespace livemvs::app
