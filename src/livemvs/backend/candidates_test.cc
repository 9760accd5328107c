#include "livemvs/backend/cpu/candidates.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include "livemvs/backend/plant_rule.h"

namespace livemvs {
namespace {

using Found = std::set<std::tuple<int, int>>;

// Patchy texture and a few marks.
struct TexturedPicture {
  Image<std::uint8_t> grey, marks;
};
TexturedPicture RandomPicture(int width, int height) {
  TexturedPicture p{Image<std::uint8_t>(width, height), Image<std::uint8_t>(width, height)};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double contrast = 40 * std::max(0.0, std::sin(x * 0.05) * std::cos(y * 0.07));
      p.grey(x, y) = static_cast<std::uint8_t>(120 + contrast * (uniform(random) - 0.5));
      p.marks(x, y) = uniform(random) < 0.02;
    }
  }
  return p;
}

// The definition, word by word.
Found Expected(const TexturedPicture& p, const CandidateRule& rule) {
  Found found;
  for (int y = rule.rect.y0; y < rule.rect.y1; ++y) {
    for (int x = rule.rect.x0; x < rule.rect.x1; ++x) {
      if (x % rule.spacing != 0 || y % rule.spacing != 0) continue;
      bool near_mark = false;
      for (int v = y - rule.cover_radius; v <= y + rule.cover_radius; ++v) {
        for (int u = x - rule.cover_radius; u <= x + rule.cover_radius; ++u) {
          const bool inside = u >= 0 && v >= 0 && u < p.marks.width() && v < p.marks.height();
          near_mark = near_mark || (inside && p.marks(u, v) != 0);
        }
      }
      double sum = 0, squares = 0;
      for (int k = 0; k < kPatchPixels; ++k) {
        const double v =
            p.grey(x + k % kPatchSize - kPatchRadius, y + k / kPatchSize - kPatchRadius);
        sum += v;
        squares += v * v;
      }
      const double mean = sum / kPatchPixels;
      const double stddev = std::sqrt(std::max(squares / kPatchPixels - mean * mean, 0.0));
      if (!near_mark && stddev >= rule.min_stddev) found.insert({x, y});
    }
  }
  return found;
}

class CandidatesTest : public ::testing::TestWithParam<std::tuple<int, int>> {};

TEST_P(CandidatesTest, AreThePixelsOfTheDefinition) {
  const auto [spacing, cover_radius] = GetParam();
  const TexturedPicture p = RandomPicture(157, 113);
  const CandidateRule rule = {{5, 4, 150, 109}, spacing, cover_radius, 6.05F};
  Candidates candidates;
  candidates.Find(p.grey.view(), p.marks.view(), rule);
  Found found;
  PhaseCounts count{};
  candidates.ForEach(0, kPhases - 1, [&](int x, int y, int phase) {
    found.insert({x, y});
    ++count[phase];
  });
  const Found expected = Expected(p, rule);
  EXPECT_GT(expected.size(), 20U);
  EXPECT_EQ(found, expected);
  EXPECT_EQ(count, candidates.count());
}

TEST_P(CandidatesTest, AreTheSameOneByOne) {
  const auto [spacing, cover_radius] = GetParam();
  const TexturedPicture p = RandomPicture(157, 113);
  const CandidateRule rule = {{5, 4, 150, 109}, spacing, cover_radius, 6.05F};
  Candidates candidates;
  candidates.Find(p.grey.view(), p.marks.view(), rule);
  using Places = std::vector<std::tuple<int, int, int>>;
  Places rows, one_by_one;
  candidates.ForEach(
      0, kPhases - 1, [&](int x, int y, int phase) { rows.emplace_back(x, y, phase); });
  const CandidateGrid grid = MakeCandidateGrid(rule);
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const int x = grid.X(i), y = grid.Y(i);
    const int candidate = CandidateAt(p.grey.view(), p.marks.view(), rule, x, y);
    if (candidate > 0) one_by_one.emplace_back(x, y, candidate - 1);
  }
  EXPECT_GT(rows.size(), 20U);
  EXPECT_EQ(one_by_one, rows) << "in the same order, too";
}

TEST_P(CandidatesTest, AreVisitedByTheirPhases) {
  const auto [spacing, cover_radius] = GetParam();
  const TexturedPicture p = RandomPicture(157, 113);
  Candidates candidates;
  candidates.Find(p.grey.view(), p.marks.view(), {{5, 4, 150, 109}, spacing, cover_radius, 6.05F});
  using Places = std::vector<std::tuple<int, int, int>>;
  for (const auto& phases : {std::pair{0, 0}, {0, 2}, {3, 9}, {15, 15}, {7, 6}}) {
    const int first = phases.first, last = phases.second;
    Places expected, found;
    candidates.ForEach(0, kPhases - 1, [&](int x, int y, int phase) {
      if (phase >= first && phase <= last) expected.emplace_back(x, y, phase);
    });
    candidates.ForEach(
        first, last, [&](int x, int y, int phase) { found.emplace_back(x, y, phase); });
    EXPECT_EQ(found, expected) << first << " to " << last;
  }
}

INSTANTIATE_TEST_SUITE_P(SpacingsAndRadii,
                         CandidatesTest,
                         ::testing::Combine(::testing::Values(1, 2, 3),
                                            ::testing::Values(-1, 0, 1, 2)));

TEST(Candidates, PhasesAreBayers) {
  const int bayer[4][4] = {{0, 8, 2, 10}, {12, 4, 14, 6}, {3, 11, 1, 9}, {15, 7, 13, 5}};
  for (int row = 0; row < 9; ++row) {
    for (int column = 0; column < 9; ++column) {
      EXPECT_EQ(PhaseOf(column, row), bayer[row % 4][column % 4]) << column << ", " << row;
    }
  }
}

TEST(Candidates, PhasesAreSpreadEvenly) {
  Image<std::uint8_t> grey(200, 200), marks(200, 200);
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 200; ++x) grey(x, y) = (x + y) % 2 == 0 ? 0 : 200;
  }
  Candidates candidates;
  candidates.Find(grey.view(), marks.view(), {{4, 4, 196, 196}, 1, 1, 10});
  for (const std::size_t n : candidates.count()) EXPECT_EQ(n, 192U * 192U / kPhases);
}

TEST(Candidates, NothingInAnEmptyRectangle) {
  Image<std::uint8_t> grey(8, 8), marks(8, 8);
  Candidates candidates;
  candidates.Find(grey.view(), marks.view(), {{3, 3, 3, 5}, 1, 1, 0});
  candidates.ForEach(0, kPhases - 1, [](int, int, int) { FAIL(); });
  EXPECT_EQ(MakeCandidateGrid({{3, 3, 3, 5}, 1, 1, 0}).size(), 0U);
  EXPECT_EQ(MakeCandidateGrid({{5, 5, 8, 8}, 8, 1, 0}).size(), 0U) << "between two of the grid";
}

}  // namespace
}  // namespace livemvs
