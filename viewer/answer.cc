#include "viewer/answer.h"

#include "viewer/page.h"

namespace livemvs::viewer {
namespace {

namespace http = boost::beast::http;

constexpr std::string_view kHtml = "text/html; charset=utf-8";

// Somebody opened an old bookmark, or the address without its token. The policy allows no style
// but the page's own, which needs the token; so this one does without.
constexpr std::string_view kRefusal =
    "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\">"
    "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">"
    "<meta name=\"color-scheme\" content=\"dark light\"><title>livemvs: not allowed</title>"
    "<h1>Not allowed</h1>"
    "<p>Open the address that livemvs printed: it holds the token of this run."
    "<p>An address of an earlier run does not let in any more.</html>\n";

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
      return {http::status::forbidden, kHtml, kRefusal};
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
