#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace livemvs::app {

/// A file that a command is to write; no path: it was not asked for.
struct Output {
  std::filesystem::path path;
  std::string what;   ///< For messages: "the cloud".
  std::string kind;   ///< Likewise: "a point cloud".
  std::string magic;  ///< First bytes of its kind; empty: any existing file may be replaced.
};

/// Refuses, before any work, outputs that cannot be written or would replace an input, each other,
/// or an existing file that is not of their kind.
/// @throws Error (kBadInput) naming path and remedy.
void CheckOutputs(const std::vector<Output>& outputs,
                  const std::vector<std::filesystem::path>& inputs);

}  // namespace livemvs::app
