#pragma once

#include <span>
#include <string_view>

namespace livemvs::viewer {

/// A file of the page, which is part of the program: nothing is read from disk.
struct Asset {
  std::string_view path;  ///< "/app.js"
  std::string_view type;  ///< Of its content, for the browser.
  std::string_view bytes;
};

/// The file of exactly this path, or nullptr.
const Asset* FindAsset(std::string_view path);

/// What the page may do, as Content-Security-Policy: nothing but its own files and its stream.
inline constexpr std::string_view kContentSecurityPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; font-src 'self'; "
    "img-src 'self' blob: data:; connect-src 'self'; manifest-src 'self'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'";

/// Likewise of the page that refuses: its one style, by the hash of that, and nothing else.
inline constexpr std::string_view kRefusalPolicy =
    "default-src 'none'; style-src 'sha256-ATEeAM815Au4yTDqV1rTSdvOB3pVyYYUo27Ifu8Us6c='; base-uri "
    "'none'; form-action 'none'; "
    "frame-ancestors 'none'";

}  // namespace livemvs::viewer
