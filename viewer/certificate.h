#pragma once

#include <string>
#include <vector>

namespace livemvs::viewer {

/// A key and a certificate that it signed itself, made anew for each run. PEM.
struct Certificate {
  std::string key;
  std::string certificate;
  std::string fingerprint;  ///< SHA-256, "AB:CD:…", as browsers show it.
};

/// @param addresses  IP addresses that it is for.
/// @throws Error (kFailed) where OpenSSL fails.
Certificate MakeCertificate(const std::vector<std::string>& addresses);

}  // namespace livemvs::viewer
