#include "livemvs/eval/stroke_font.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace livemvs {
namespace {

constexpr double kGap = 1.7;    ///< Between characters.
constexpr double kSpace = 2.6;  ///< Advance of a space.
constexpr double kBaseline = 2;

/// Strokes of the characters from '!' to '~': points as digit pairs "xy", pieces apart by spaces.
/// Descenders reach down to y = 0, the baseline is 2, small letters reach 6 and capitals 8.
constexpr std::array<std::string_view, 94> kStrokes = {
    "0805 0202",                         // !
    "0806 1816",                         // "
    "1317 3337 0444 0646",               // #
    "473818070615354443321203 2921",     // $
    "0248 0818170708 3343423233",        // %
    "420607182837360403122244",          // &
    "0806",                              // '
    "19070311",                          // (
    "09171301",                          // )
    "2723 0446 0644",                    // *
    "2723 0545",                         // +
    "1201",                              // ,
    "0535",                              // -
    "0202",                              // .
    "0148",                              // /
    "182837332212030718",                // 0
    "072822 0242",                       // 1
    "07183847460242",                    // 2
    "07183847463515 354443321203",       // 3
    "32380444",                          // 4
    "480805354443321203",                // 5
    "473818070312324344351504",          // 6
    "084812",                            // 7
    "15060718384746351504031232434435",  // 8
    "031232434738180706153546",          // 9
    "0303 0606",                         // :
    "1201 1616",                         // ;
    "370533",                            // <
    "0434 0636",                         // =
    "073503",                            // >
    "07183847462524 2222",               // ?
    "433212030718384744341416 3634",     // @
    "022842 1434",                       // A
    "02083847463505 3544433202",         // B
    "4738180703123243",                  // C
    "02082846442202",                    // D
    "48080242 0535",                     // E
    "480802 0535",                       // F
    "47381807031232434525",              // G
    "0802 4842 0545",                    // H
    "0828 1812 0222",                    // I
    "3833221203",                        // J
    "0802 4805 1642",                    // K
    "080242",                            // L
    "0208254842",                        // M
    "02084248",                          // N
    "183847433212030718",                // O
    "02083847463505",                    // P
    "183847433212030718 2442",           // Q
    "02083847463505 2542",               // R
    "473818070615354443321203",          // S
    "0848 2822",                         // T
    "080312324348",                      // U
    "082248",                            // V
    "0812253248",                        // W
    "0842 0248",                         // X
    "082548 2522",                       // Y
    "08480242",                          // Z
    "19090111",                          // [
    "0842",                              // backslash
    "09191101",                          // ]
    "061826",                            // ^
    "0141",                              // _
    "0817",                              // `
    "0516263532 341403122233",           // a
    "0802 0516263533221203",             // b
    "3526160503122233",                  // c
    "3832 3526160503122233",             // d
    "04343526160503122233",              // e
    "38281712 0636",                     // f
    "3631201001 3526160503122233",       // g
    "0802 0516263532",                   // h
    "0602 0808",                         // i
    "161100 1818",                       // j
    "0802 3604 1532",                    // k
    "0802",                              // l
    "0602 05162522 25364542",            // m
    "0602 0516263532",                   // n
    "162635332212030516",                // o
    "0600 0516263533221203",             // p
    "3630 3526160503122233",             // q
    "0602 041626",                       // r
    "35261605142433221203",              // s
    "18132232 0636",                     // t
    "0603122233 3632",                   // u
    "062246",                            // v
    "0612243246",                        // w
    "0632 0236",                         // x
    "0622 4610",                         // y
    "06360232",                          // z
    "29181605141221",                    // {
    "0901",                              // |
    "09181625141201",                    // }
    "04152435",                          // ~
};
constexpr std::string_view kBox = "0208484202";

}  // namespace

Glyph GlyphOf(char c) {
  Glyph glyph;
  if (c == ' ') {
    glyph.advance = kSpace;
    return glyph;
  }
  const int index = c - '!';
  const bool known = index >= 0 && index < static_cast<int>(kStrokes.size());
  const std::string_view text = known ? kStrokes[static_cast<std::size_t>(index)] : kBox;
  glyph.strokes.emplace_back();
  for (std::size_t i = 0; i < text.size();) {
    if (text[i] == ' ') {
      glyph.strokes.emplace_back();
      ++i;
      continue;
    }
    const Eigen::Vector2d p(text[i] - '0', text[i + 1] - '0' - kBaseline);
    glyph.strokes.back().push_back(p);
    glyph.advance = std::max(glyph.advance, p.x() + kGap);
    i += 2;
  }
  return glyph;
}

}  // namespace livemvs
