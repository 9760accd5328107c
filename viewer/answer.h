#pragma once

/// What a request gets, apart from the stream. Private to the server.

#include <ostream>  // which Boost 1.74 needs here, and does not include

#include <boost/beast/http/status.hpp>
#include <string_view>

#include "viewer/page.h"
#include "viewer/rules.h"

namespace livemvs::viewer {

struct Answer {
  boost::beast::http::status status;
  std::string_view type = "text/plain; charset=utf-8";
  std::string_view body;
  std::string_view policy = kContentSecurityPolicy;
};

/// @param path  Of the request, without what follows a question mark.
Answer AnswerTo(Verdict verdict, std::string_view path);

}  // namespace livemvs::viewer
