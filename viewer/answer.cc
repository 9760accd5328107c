#include "viewer/answer.h"

#include <string>

#include "viewer/page.h"

namespace livemvs::viewer {
namespace {

namespace http = boost::beast::http;

constexpr std::string_view kHtml = "text/html; charset=utf-8";

// The page's plain look, without its files, which need the token.
constexpr std::string_view kRefusalStyle =
    ":root{color-scheme:dark light;--ink:#eef1f5;--soft:#a2a8b1;--panel:#1c2027;--edge:#30353d;"
    "--top:#1b2027;--bottom:#0e1115}"
    "@media(prefers-color-scheme:light){:root{--ink:#15181d;--soft:#565c66;--panel:#fff;"
    "--edge:#d5dae1;--top:#fff;--bottom:#dfe4ea}}"
    "*{box-sizing:border-box;margin:0}"
    "body{min-height:100vh;display:grid;grid-template-rows:auto 1fr auto;justify-items:center;"
    "align-items:center;padding:16px;color:var(--ink);"
    "background:linear-gradient(var(--top),var(--bottom)) fixed;"
    "font:400 15px/1.5 system-ui,sans-serif}"
    "header{justify-self:start;font-size:17px;font-weight:650;letter-spacing:-.02em}"
    "main{max-width:460px;padding:22px 24px;border:1px solid var(--edge);border-radius:16px;"
    "background:var(--panel)}"
    "h1{font-size:20px;font-weight:600;letter-spacing:-.01em}"
    "p{margin-top:10px;color:var(--soft)}";

// Somebody opened an old bookmark, or the address without its token.
const std::string& RefusalPage() {
  static const std::string kPage =
      "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">"
      "<title>livemvs: not allowed</title><style>" +
      std::string(kRefusalStyle) +
      "</style>"
      "<header>livemvs</header><main><h1>Not allowed</h1>"
      "<p>Open the address that livemvs printed when it was started, whole: it ends with the token "
      "that lets you in."
      "<p>Each run has a token of its own, so that the address of an earlier one does not work any "
      "more.</main></html>\n";
  return kPage;
}

}  // namespace

Answer AnswerTo(Verdict verdict, std::string_view path) {
  switch (verdict) {
    case Verdict::kPage:
      return {http::status::ok, FindAsset("/")->type, FindAsset("/")->bytes};
    case Verdict::kAsset:
      return {http::status::ok, FindAsset(path)->type, FindAsset(path)->bytes};
    case Verdict::kBadMethod:
      return {.status = http::status::method_not_allowed, .body = "GET and HEAD are understood.\n"};
    case Verdict::kForbidden:
      return {http::status::forbidden, kHtml, RefusalPage(), kRefusalPolicy};
    case Verdict::kWrongHost:
      return {.status = http::status::misdirected_request,
              .body =
                  "This server is not known under that name. Open the address that livemvs "
                  "printed.\n"};
    case Verdict::kWrongOrigin:
      return {.status = http::status::forbidden, .body = "Other pages may not read this one.\n"};
    case Verdict::kStream:
    case Verdict::kNotFound:
      break;
  }
  return {.status = http::status::not_found, .body = "There is no such page.\n"};
}

}  // namespace livemvs::viewer
