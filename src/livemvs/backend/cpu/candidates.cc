#include "livemvs/backend/cpu/candidates.h"

#include <array>
#include <cstring>
#include <mutex>
#include <vector>

#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

constexpr std::size_t kRowsPerTask = 32;

// Finds the candidates of rows of the grid, as CandidateAt() does one by one. Loops run over whole
// rows, one quantity each, so that the compiler makes vectors of them.
class RowFinder {
 public:
  RowFinder(const ImageView<std::uint8_t>& grey,
            const ImageView<std::uint8_t>& marks,
            const CandidateRule& rule)
      : grey_(grey),
        marks_(marks),
        rule_(rule),
        sum_(grey.width),
        squares_(grey.width),
        flat_(grey.width),
        marked_(grey.width + 2 * std::max(rule.cover_radius, 0)) {
    for (int row = 0; row < kCell; ++row) phases_[row] = PhasesOfRow(row);
  }

  // Writes 1 + phase of each pixel of row y of the picture, or 0. Rows come one after the other.
  void Find(int y, std::uint8_t* __restrict out) {
    MoveColumnsTo(y);
    FindFlat();
    if (rule_.cover_radius >= 0) AddMarked(y);
    const std::uint8_t* __restrict flat = flat_.data();
    const std::uint8_t* __restrict phases = phases_[y / rule_.spacing % kCell].data();
    for (int x = 0; x < grey_.width; ++x) {
      out[x] = phases[x] & static_cast<std::uint8_t>(flat[x] - 1);
    }
  }

 private:
  // 1 + the phase of each pixel of a row that may be planted; 0 off the grid and out of the
  // rectangle.
  std::vector<std::uint8_t> PhasesOfRow(int row) const {
    std::vector<std::uint8_t> phases(grey_.width);
    const CandidateGrid grid = MakeCandidateGrid(rule_);
    for (int i = 0; i < grid.columns; ++i) {
      phases[grid.X(i)] = static_cast<std::uint8_t>(1 + PhaseOf(grid.column + i, row));
    }
    return phases;
  }

  // Sums over columns of kPatchSize pixels about row y.
  void MoveColumnsTo(int y) {
    if (y - row_ <= kPatchRadius) {
      for (int v = row_ + 1; v <= y; ++v) AddRow(v + kPatchRadius, v - kPatchRadius - 1);
    } else {
      std::fill(sum_.begin(), sum_.end(), 0.0F);
      std::fill(squares_.begin(), squares_.end(), 0.0F);
      for (int dy = -kPatchRadius; dy <= kPatchRadius; ++dy) AddRow(y + dy, -1);
    }
    row_ = y;
  }

  // Adds a row to the columns, and takes another off unless it is -1.
  void AddRow(int added, int removed) {
    const std::uint8_t* __restrict in = grey_.Row(added);
    float* __restrict sum = sum_.data();
    float* __restrict squares = squares_.data();
    if (removed < 0) {
      for (int x = 0; x < grey_.width; ++x) {
        const auto v = static_cast<float>(in[x]);
        sum[x] += v;
        squares[x] += v * v;
      }
      return;
    }
    const std::uint8_t* __restrict out = grey_.Row(removed);
    for (int x = 0; x < grey_.width; ++x) {
      const auto v = static_cast<float>(in[x]), w = static_cast<float>(out[x]);
      sum[x] += v - w;
      squares[x] += v * v - w * w;
    }
  }

  // 1 where a patch has too little contrast.
  void FindFlat() {
    const float least = LeastContrast(rule_);
    const float* __restrict sum = sum_.data();
    const float* __restrict squares = squares_.data();
    std::uint8_t* __restrict flat = flat_.data();
    static_assert(kPatchRadius == 2);
    for (int x = rule_.rect.x0; x < rule_.rect.x1; ++x) {
      const float s = sum[x - 2] + sum[x - 1] + sum[x] + sum[x + 1] + sum[x + 2];
      const float q =
          squares[x - 2] + squares[x - 1] + squares[x] + squares[x + 1] + squares[x + 2];
      flat[x] = static_cast<std::uint8_t>(IsFlat(s, q, least));
    }
  }

  // 1 also where a mark is near.
  void AddMarked(int y) {
    const int radius = rule_.cover_radius, width = grey_.width;
    std::uint8_t* __restrict marked = marked_.data() + radius;
    std::memset(marked, 0, static_cast<std::size_t>(width));
    for (int v = std::max(y - radius, 0); v <= std::min(y + radius, marks_.height - 1); ++v) {
      const std::uint8_t* __restrict row = marks_.Row(v);
      for (int x = 0; x < width; ++x) marked[x] |= row[x];
    }
    std::uint8_t* __restrict flat = flat_.data();
    for (int dx = -radius; dx <= radius; ++dx) {
      for (int x = 0; x < width; ++x) flat[x] |= marked[x + dx];
    }
  }

  ImageView<std::uint8_t> grey_, marks_;
  CandidateRule rule_;
  std::array<std::vector<std::uint8_t>, kCell> phases_;
  int row_ = -kPatchSize;  // the columns are about it; none yet
  std::vector<float> sum_, squares_;
  std::vector<std::uint8_t> flat_;    // 1 where nothing is planted
  std::vector<std::uint8_t> marked_;  // with a margin of the radius on both sides
};

}  // namespace

void Candidates::Find(const ImageView<std::uint8_t>& grey,
                      const ImageView<std::uint8_t>& marks,
                      const CandidateRule& rule) {
  if (phase_.width() != grey.width || phase_.height() != grey.height) {
    phase_ = Image<std::uint8_t>(grey.width, grey.height);
  }
  grid_ = MakeCandidateGrid(rule);
  count_.fill(0);
  if (grid_.columns == 0) return;
  std::mutex mutex;
  ParallelForRange(0, grid_.rows, kRowsPerTask, [&](std::size_t first, std::size_t last) {
    RowFinder finder(grey, marks, rule);
    PhaseCounts count{};
    for (std::size_t i = first; i < last; ++i) {
      const int row = grid_.row + static_cast<int>(i);
      finder.Find(row * grid_.spacing, phase_.Row(row * grid_.spacing));
      ForEachInRow(row, 0, kPhases - 1, [&](int, int, int phase) { ++count[phase]; });
    }
    const std::scoped_lock lock(mutex);
    for (int p = 0; p < kPhases; ++p) count_[p] += count[p];
  });
}

}  // namespace livemvs
