#if defined(__x86_64__)
#include <cpuid.h>
#endif

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>

#include "livemvs/backend/backend.h"
#include "livemvs/backend/cpu/host_seeds.h"
#include "livemvs/backend/cpu/kernels.h"
#include "livemvs/backend/cpu/planter.h"
#include "livemvs/backend/cpu/row_pairs.h"
#include "livemvs/backend/warp_rule.h"
#include "livemvs/parallel/parallel_for.h"

namespace livemvs {

// The kernel that kernels.cc makes for a target.
#define LIVEMVS_DECLARE_KERNEL(target)                                               \
  namespace target {                                                                 \
  UpdateStatistics Update(const UpdateJob& job, std::size_t begin, std::size_t end); \
  void Mark(const MarkJob& job, std::size_t begin, std::size_t end);                 \
  }
#if defined(__x86_64__)
LIVEMVS_DECLARE_KERNEL(avx512gathers)
LIVEMVS_DECLARE_KERNEL(avx512vnni)
LIVEMVS_DECLARE_KERNEL(avx512)
LIVEMVS_DECLARE_KERNEL(avx2)
#endif
LIVEMVS_DECLARE_KERNEL(portable)
LIVEMVS_DECLARE_KERNEL(single)
#undef LIVEMVS_DECLARE_KERNEL

#if defined(__x86_64__)
namespace {

// Whether a gather of eight words is faster than as many loads: on the processors that have
// AVX512-FP16, Intel's since Sapphire Rapids. On AMD's Zen 4 it is not, and on older ones of Intel
// the microcode against "Downfall" slows gathers down.
bool GathersAreFast() {
  constexpr unsigned kFp16 = 1U << 23;  // CPUID leaf 7, edx
  unsigned eax = 0, ebx = 0, ecx = 0, edx = 0;
  return __get_cpuid_count(7, 0, &eax, &ebx, &ecx, &edx) != 0 && (edx & kFp16) != 0;
}

}  // namespace
#endif

std::vector<NamedKernel> UsableKernels() {
  std::vector<NamedKernel> kernels;
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq")) {
    if (__builtin_cpu_supports("avx512vnni")) {
      if (GathersAreFast()) {
        kernels.push_back({"AVX-512 VNNI gathers", avx512gathers::Update, avx512gathers::Mark});
      }
      kernels.push_back({"AVX-512 VNNI", avx512vnni::Update, avx512vnni::Mark});
    }
    kernels.push_back({"AVX-512", avx512::Update, avx512::Mark});
  }
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
    kernels.push_back({"AVX2", avx2::Update, avx2::Mark});
#endif
  kernels.push_back({"portable", portable::Update, portable::Mark});
  kernels.push_back({"single lane", single::Update, single::Mark});
  return kernels;
}

namespace {

// The kernel that the environment asks for, or else the fastest.
NamedKernel ChooseKernel() {
  const std::vector<NamedKernel> kernels = UsableKernels();
  const char* wanted = std::getenv(kInstructionsVariable);
  if (wanted == nullptr || *wanted == 0) return kernels.front();
  std::string usable;
  for (const NamedKernel& kernel : kernels) {
    if (std::string_view(kernel.name) == wanted) return kernel;
    usable += std::string(usable.empty() ? "" : ", ") + kernel.name;
  }
  throw std::invalid_argument(std::string(kInstructionsVariable) + "=" + wanted +
                              ": this processor can run " + usable);
}

// A living seed from the middle of a group on, or else before it; the group's end if there is none.
std::size_t LivingSeed(const SeedColumns& seeds, const SeedGroup& group) {
  const std::size_t middle = (group.begin + group.end) / 2;
  for (std::size_t i = middle; i < group.end; ++i) {
    if (seeds.fate[i] == Fate::kAlive) return i;
  }
  for (std::size_t i = group.begin; i < middle; ++i) {
    if (seeds.fate[i] == Fate::kAlive) return i;
  }
  return group.end;
}

// Seeds per task: enough to amortise the scheduler, few enough to balance two cores.
constexpr std::size_t kSeedsPerTask = 2048;

struct Task {
  UpdateJob job;
  std::size_t begin;
  std::size_t end;
};

class CpuBackend final : public Backend {
 public:
  explicit CpuBackend(const Options& options)
      : options_(options),
        is_outlier_(options.eta_outlier, options.outlier_certainty),
        warp_rule_(options),
        kernel_(ChooseKernel()),
        seeds_(static_cast<std::size_t>(options.max_seeds)),
        planter_(options_, kernel_.mark) {}

  std::string name() const override { return std::string("CPU, ") + kernel_.name; }

  std::size_t capacity() const override { return seeds_.capacity(); }

  void SetFrame(std::span<const ImageView<std::uint8_t>> pyramid) override { pyramid_ = pyramid; }

  UpdateStatistics Update(std::span<const SeedGroup> groups, CameraModel model) override {
    tasks_.clear();
    pairs_.resize(pyramid_.size());
    std::vector<bool> paired(pyramid_.size());
    for (const SeedGroup& group : groups) {
      const auto level = static_cast<std::size_t>(group.level);
      const bool warp = NeedsWarp(group, pyramid_[level]);
      if (warp && !paired[level]) {
        pairs_[level].Build(pyramid_[level]);
        paired[level] = true;
      }
      const UpdateJob job = {&options_,
                             &is_outlier_,
                             seeds_.columns(),
                             &group,
                             model,
                             {pyramid_[level], pairs_[level].view()},
                             warp};
      for (std::size_t begin = group.begin; begin < group.end; begin += kSeedsPerTask) {
        tasks_.push_back({job, begin, std::min(begin + kSeedsPerTask, group.end)});
      }
    }
    results_.assign(tasks_.size(), {});
    ParallelFor(tasks_.size(), [&](std::size_t i) {
      results_[i] = kernel_.update(tasks_[i].job, tasks_[i].begin, tasks_[i].end);
    });
    UpdateStatistics sum;
    for (const UpdateStatistics& r : results_) sum += r;
    return sum;
  }

  std::span<const EndedSeed> TakeEnded() override { return seeds_.TakeEnded(); }

  void Compact() override { seeds_.Compact(); }

  std::vector<std::size_t> Plant(const Planting& planting) override {
    return planter_.Plant(planting, pyramid_, &seeds_);
  }

  void ForgetPoints() override { planter_.ForgetPoints(); }

  std::vector<SeedState> Read(std::size_t begin, std::size_t end, std::size_t step) override {
    return seeds_.Read(begin, end, step);
  }

  std::vector<std::uint8_t> ReadPatches(std::size_t begin, std::size_t end) override {
    return seeds_.ReadPatches(begin, end);
  }

 private:
  bool NeedsWarp(const SeedGroup& group, const ImageView<std::uint8_t>& image) const {
    if (!WarpRule::Allows(image.width, image.height)) return false;
    if (warp_rule_.Turned(group.view)) return true;
    const SeedColumns& s = seeds_.columns();
    const std::size_t i = LivingSeed(s, group);
    return i != group.end && warp_rule_.Scaled(group.view, s, i);
  }

  Options options_;
  OutlierRule is_outlier_;
  WarpRule warp_rule_;
  NamedKernel kernel_;
  HostSeeds seeds_;
  Planter planter_;
  std::span<const ImageView<std::uint8_t>> pyramid_;
  std::vector<RowPairs> pairs_;  // of the levels whose seeds need them
  std::vector<Task> tasks_;
  std::vector<UpdateStatistics> results_;
};

}  // namespace

std::unique_ptr<Backend> MakeCpuBackend(const Options& options) {
  return std::make_unique<CpuBackend>(options);
}

}  // namespace livemvs
