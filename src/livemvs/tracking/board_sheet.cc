#include "livemvs/tracking/board_sheet.h"

#include <cmath>
#include <stdexcept>
#include <vector>

#include "livemvs/core/format_text.h"
#include "livemvs/io/atomic_file.h"
#include "livemvs/tracking/sheet_layout.h"

namespace livemvs {
namespace {

constexpr double kPoints = 72 / 0.0254;  // per metre

// The page's drawing in PDF's language: points from the lower left corner, y up.
std::string Content(const SheetLayout& layout, double page_height) {
  std::string content;
  for (const SheetLayout::Layer& layer : layout.layers) {
    if (layer.rects.empty()) continue;
    content += layer.white ? "1 g\n" : "0 g\n";
    // One path for all of a layer, so that no seams show between neighbours.
    for (const SheetLayout::Rect& r : layer.rects) {
      content += FormatText("%.5f %.5f %.5f %.5f re\n",
                            r.x * kPoints,
                            (page_height - r.y - r.height) * kPoints,
                            r.width * kPoints,
                            r.height * kPoints);
    }
    content += "f\n";
  }
  content += "0 g\n";
  for (const SheetLayout::Text& t : layout.texts) {
    content += FormatText("BT /F1 %.3f Tf %.3f %.3f Td (",
                          t.size * kPoints,
                          t.x * kPoints,
                          (page_height - t.y) * kPoints);
    for (const char c : t.words) {
      if (c == '(' || c == ')' || c == '\\') content += '\\';
      content += c;
    }
    content += ") Tj ET\n";
  }
  return content;
}

}  // namespace

void WriteSheetPdf(const std::filesystem::path& path, const Board& board, const Page& page) {
  board.Check();
  const std::string content = Content(LayOutSheet(board, page), page.height);
  const std::vector<std::string> objects = {
      "<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
      "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
      FormatText(
          "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 %.4f %.4f] /Contents 4 0 R /Resources << "
          "/Font << /F1 5 0 R >> >> >>",
          page.width * kPoints,
          page.height * kPoints),
      "<< /Length " + std::to_string(content.size()) + " >>\nstream\n" + content + "endstream",
      "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>"};
  std::string pdf = "%PDF-1.6\n";
  std::string table =
      FormatText("xref\n0 %d\n0000000000 65535 f \n", static_cast<int>(objects.size()) + 1);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    table += FormatText("%010zu 00000 n \n", pdf.size());
    pdf += std::to_string(i + 1) + " 0 obj\n" + objects[i] + "\nendobj\n";
  }
  const std::size_t start = pdf.size();
  pdf += table + FormatText("trailer\n<< /Size %d /Root 1 0 R >>\nstartxref\n%zu\n%%%%EOF\n",
                            static_cast<int>(objects.size()) + 1,
                            start);
  AtomicFile file(path);
  file.Write(pdf);
  file.Commit();
}

Image<std::uint8_t> DrawSheet(const Board& board, const Page& page, double dots_per_inch) {
  board.Check();
  if (!(dots_per_inch >= 36 && dots_per_inch <= 2400)) {
    throw std::invalid_argument("dots per inch must be 36 to 2400");
  }
  const double per_metre = dots_per_inch / 0.0254;
  if (page.width * page.height * per_metre * per_metre > 4e8) {
    throw std::invalid_argument(
        "the picture would have more than 400 million pixels; take fewer dots per inch");
  }
  return Paint(LayOutSheet(board, page),
               static_cast<int>(std::ceil(page.width * per_metre)),
               static_cast<int>(std::ceil(page.height * per_metre)),
               per_metre);
}

Image<std::uint8_t> DrawBoard(const Board& board, int pixels_per_square) {
  board.Check();
  if (pixels_per_square < 1 || pixels_per_square > 1000) {
    throw std::invalid_argument("pixels_per_square must be 1 to 1000");
  }
  SheetLayout layout;
  AddBoard(board, 0, 0, &layout);
  return Paint(layout,
               board.columns * pixels_per_square,
               board.rows * pixels_per_square,
               pixels_per_square / board.square);
}

}  // namespace livemvs
