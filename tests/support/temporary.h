#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>

namespace livemvs::testing_support {

/// A file or folder of that name in a folder of the running test's own, so that tests may run side
/// by side.
inline std::filesystem::path Temporary(const std::string& name) {
  const ::testing::TestInfo& test = *::testing::UnitTest::GetInstance()->current_test_info();
  std::string own = std::string(test.test_suite_name()) + "." + test.name();
  std::ranges::replace(own, '/', '_');
  const std::filesystem::path folder =
      std::filesystem::path(::testing::TempDir()) / "livemvs_tests" / own;
  std::filesystem::create_directories(folder);
  return folder / name;
}

}  // namespace livemvs::testing_support
