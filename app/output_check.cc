#include "output_check.h"

#include <fstream>
#include <system_error>

#include "livemvs/core/error.h"
#include "livemvs/io/atomic_file.h"

namespace livemvs::app {
namespace {

namespace fs = std::filesystem;

bool Same(const fs::path& a, const fs::path& b) {
  std::error_code ignored;
  return !a.empty() && !b.empty() &&
         fs::weakly_canonical(a, ignored) == fs::weakly_canonical(b, ignored);
}

void CheckKind(const Output& output) {
  if (output.magic.empty() || !fs::is_regular_file(output.path)) return;
  std::ifstream existing(output.path, std::ios::binary);
  std::string start(output.magic.size(), '\0');
  if (existing.read(start.data(), static_cast<std::streamsize>(start.size())) &&
      start != output.magic) {
    throw BadInput(output.path.string() + ": exists and is not " + output.kind +
                   "; remove it or name another file");
  }
}

}  // namespace

void CheckOutputs(const std::vector<Output>& outputs, const std::vector<fs::path>& inputs) {
  for (const Output& output : outputs) {
    if (!output.path.empty()) CheckWritable(output.path);
  }
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    for (std::size_t j = i + 1; j < outputs.size(); ++j) {
      if (Same(outputs[i].path, outputs[j].path)) {
        throw BadInput(outputs[i].path.string() + ": cannot be both " + outputs[i].what + " and " +
                       outputs[j].what);
      }
    }
    for (const fs::path& input : inputs) {
      if (Same(outputs[i].path, input)) {
        throw BadInput(outputs[i].path.string() + ": is an input; name another file");
      }
    }
    CheckKind(outputs[i]);
  }
}

}  // namespace livemvs::app
