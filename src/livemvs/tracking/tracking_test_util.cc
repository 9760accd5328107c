#include "livemvs/tracking/tracking_test_util.h"

#include <cstdlib>

namespace livemvs::testing_tracking {

std::filesystem::path RealData(const std::string& name) {
  const char* variable = std::getenv("LIVEMVS_DATA");
  const std::filesystem::path base =
      variable != nullptr && *variable != '\0'
          ? std::filesystem::path(variable)
          : std::filesystem::path(LIVEMVS_SOURCE_DIR) / "../shared/data";
  return std::filesystem::is_directory(base / name) ? base / name : std::filesystem::path();
}

}  // namespace livemvs::testing_tracking
