#pragma once

#include <filesystem>
#include <string>

namespace livemvs::testing_tracking {

/// A folder of the recordings that tests may use, or an empty path where it is not there.
std::filesystem::path RealData(const std::string& name);

}  // namespace livemvs::testing_tracking
