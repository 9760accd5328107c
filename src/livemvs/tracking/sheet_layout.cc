#include "livemvs/tracking/sheet_layout.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "livemvs/tracking/dictionary.h"

namespace livemvs {
namespace {

constexpr double kInch = 0.0254;
constexpr double kMargin = 0.005;      // that must stay around the board [m]
constexpr double kFooter = 0.013;      // for ruler and words [m]
constexpr double kLetterSize = 0.003;  // [m]

// White bits lie on a black square.
void AddMarker(
    const Board& board, const BoardMarker& m, double left, double top, SheetLayout* out) {
  const double inset = 0.5 * (board.square - board.marker);
  const double x0 = left + m.column * board.square + inset, y0 = top + m.row * board.square + inset;
  out->layers.push_back({false, {{x0, y0, board.marker, board.marker}}});
  const MarkerBits bits = BitsOf(board.dictionary, m.id);
  const double cell = board.marker / (bits.side + 2);
  SheetLayout::Layer white{true, {}};
  for (int y = 0; y < bits.side; ++y) {
    for (int x = 0; x < bits.side; ++x) {
      if (bits.white[y * bits.side + x] == 0) continue;
      white.rects.push_back({x0 + (x + 1) * cell, y0 + (y + 1) * cell, cell, cell});
    }
  }
  out->layers.push_back(std::move(white));
}

void AddRuler(double left, double top, double length, SheetLayout* out) {
  constexpr double kLine = 0.0003;
  SheetLayout::Layer ruler{false, {{left, top - kLine / 2, length, kLine}}};
  const int steps = static_cast<int>(std::lround(length / 0.01));
  for (int i = 0; i <= steps; ++i) {
    const double height = i % 5 == 0 ? 0.004 : 0.002;
    // The outer edges of the end marks are the ruler's ends.
    const double x = left + i * 0.01 - (i == 0 ? 0 : i == steps ? kLine : kLine / 2);
    ruler.rects.push_back({x, top - height, kLine, height});
  }
  out->layers.push_back(std::move(ruler));
}

std::string Describe(const Board& board) {
  char text[200];
  std::snprintf(text,
                sizeof text,
                "%d x %d squares of %.6g mm, markers %.6g mm, %s",
                board.columns,
                board.rows,
                1e3 * board.square,
                1e3 * board.marker,
                board.dictionary.c_str());
  return text;
}

}  // namespace

Page PageByName(const std::string& name, const Board& board) {
  if (name == "A4") return {name, 0.297, 0.210};
  if (name == "A3") return {name, 0.420, 0.297};
  if (name == "Letter") return {name, 11 * kInch, 8.5 * kInch};
  if (name == "fit") {
    return {
        name, std::max(0.08, board.width() + 4 * kMargin), board.height() + 4 * kMargin + kFooter};
  }
  throw std::invalid_argument("page '" + name + "': must be A4, A3, Letter or fit");
}

Board BoardForPage(const std::string& page) {
  Board board;
  board.square = page == "A4" ? 0.022 : page == "A3" ? 0.032 : page == "Letter" ? 0.021 : 0.035;
  board.marker = std::floor(750 * board.square) / 1000;  // three quarters, in whole millimetres
  return board;
}

void AddBoard(const Board& board, double left, double top, SheetLayout* layout) {
  // Black squares of a row meet at corners only; all of them are one shape.
  SheetLayout::Layer squares{false, {}};
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      if (!board.IsBlack(column, row) || board.IsPlain(column, row)) continue;
      squares.rects.push_back(
          {left + column * board.square, top + row * board.square, board.square, board.square});
    }
  }
  layout->layers.push_back(std::move(squares));
  for (const BoardMarker& marker : MarkersOf(board)) AddMarker(board, marker, left, top, layout);
}

SheetLayout LayOutSheet(const Board& board, const Page& page) {
  const double spare_x = page.width - board.width();
  const double spare_y = page.height - kFooter - board.height();
  if (spare_x < 2 * kMargin - 1e-9 || spare_y < 2 * kMargin - 1e-9) {
    char text[300];
    std::snprintf(text,
                  sizeof text,
                  "the board of %.6g x %.6g mm does not fit the page %s of %.6g x %.6g mm (5 mm "
                  "margin, 13 mm "
                  "for the ruler); take smaller squares, fewer of them, or another page",
                  1e3 * board.width(),
                  1e3 * board.height(),
                  page.name.c_str(),
                  1e3 * page.width,
                  1e3 * page.height);
    throw std::invalid_argument(text);
  }
  SheetLayout layout;
  const double left = 0.5 * spare_x, top = 0.5 * spare_y;
  AddBoard(board, left, top, &layout);
  const double length = page.width > 0.15 ? 0.1 : 0.05;
  const double base = page.height - std::min(0.008, 0.5 * (kFooter));
  AddRuler(left, base, length, &layout);
  layout.texts.push_back({left + length + 0.003,
                          base,
                          kLetterSize,
                          length > 0.07 ? "This line is 100 mm long. If not: print at 100 %."
                                        : "50 mm. If not: print at 100 %."});
  if (page.width > 0.2) {
    layout.texts.push_back({left + length + 0.075, base, kLetterSize, Describe(board)});
  }
  return layout;
}

Image<std::uint8_t> Paint(const SheetLayout& layout, int width, int height, double per_metre) {
  Image<float> canvas(width, height);
  for (int y = 0; y < height; ++y) std::fill_n(canvas.Row(y), width, 1.f);
  // Covered part of the pixel i by [low, high).
  const auto covered = [](int i, double low, double high) {
    return std::max(0.0, std::min(high, i + 1.0) - std::max(low, static_cast<double>(i)));
  };
  for (const SheetLayout::Layer& layer : layout.layers) {
    for (const SheetLayout::Rect& r : layer.rects) {
      const double x0 = r.x * per_metre, x1 = (r.x + r.width) * per_metre;
      const double y0 = r.y * per_metre, y1 = (r.y + r.height) * per_metre;
      for (int y = std::max(0, static_cast<int>(y0)); y < std::min<double>(height, y1); ++y) {
        for (int x = std::max(0, static_cast<int>(x0)); x < std::min<double>(width, x1); ++x) {
          const auto change = static_cast<float>(covered(x, x0, x1) * covered(y, y0, y1));
          canvas(x, y) += layer.white ? change : -change;
        }
      }
    }
  }
  Image<std::uint8_t> image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image(x, y) =
          static_cast<std::uint8_t>(std::lround(255 * std::clamp(canvas(x, y), 0.f, 1.f)));
    }
  }
  return image;
}

}  // namespace livemvs
