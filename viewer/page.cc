#include "viewer/page.h"

#include <array>

// The assembler puts the built page (web/dist) into the program.
#define LIVEMVS_EMBED(name, file)               \
  __asm__(                                      \
      ".section .rodata\n"                      \
      ".balign 16\n"                            \
      "livemvs_page_" #name                     \
      ":\n"                                     \
      ".incbin \"" LIVEMVS_PAGE_FOLDER "/" file \
      "\"\n"                                    \
      "livemvs_page_" #name                     \
      "_end:\n"                                 \
      ".byte 0\n"                               \
      ".previous\n");                           \
  extern "C" const char livemvs_page_##name[];  \
  extern "C" const char livemvs_page_##name##_end[]

LIVEMVS_EMBED(html, "index.html");
LIVEMVS_EMBED(script, "app.js");
LIVEMVS_EMBED(style, "app.css");
LIVEMVS_EMBED(font, "inter.woff2");
LIVEMVS_EMBED(icon, "icon.svg");

namespace livemvs::viewer {
namespace {

std::string_view Between(const char* begin, const char* end) {
  return {begin, static_cast<std::size_t>(end - begin)};
}

}  // namespace

const Asset* FindAsset(std::string_view path) {
  static const std::array<Asset, 5> kAssets = {{
      {"/", "text/html; charset=utf-8", Between(livemvs_page_html, livemvs_page_html_end)},
      {"/app.js",
       "text/javascript; charset=utf-8",
       Between(livemvs_page_script, livemvs_page_script_end)},
      {"/app.css", "text/css; charset=utf-8", Between(livemvs_page_style, livemvs_page_style_end)},
      {"/inter.woff2", "font/woff2", Between(livemvs_page_font, livemvs_page_font_end)},
      {"/icon.svg", "image/svg+xml", Between(livemvs_page_icon, livemvs_page_icon_end)},
  }};
  for (const Asset& asset : kAssets) {
    if (asset.path == path) return &asset;
  }
  return nullptr;
}

}  // namespace livemvs::viewer
