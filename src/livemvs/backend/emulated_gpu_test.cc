// What a GPU does that cannot be asked of a real one: it is too small, or gets lost. Everything
// else about it is in the tests of all backends, which run on the emulated one, too.

#include <cuda_runtime.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "livemvs/backend/backend.h"
#include "livemvs/backend/cuda/cuda_backend.h"
#include "plane_scene.h"

namespace livemvs {
namespace {

using testing_support::PlaneScene;
using testing_support::SidewaysPath;
using testing_support::TestOptions;

class EmulatedGpu : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const char* memory = std::getenv(kEmulatedGpuVariable)) before_ = memory;
    SetMemory("4096");
  }
  void TearDown() override {
    emulated_cuda::LoseDeviceAfter(-1);
    emulated_cuda::WorkAtOnce(false);
    if (before_.empty()) {
      ::unsetenv(kEmulatedGpuVariable);
    } else {
      SetMemory(before_.c_str());
    }
  }

  static void SetMemory(const char* mebibytes) { ::setenv(kEmulatedGpuVariable, mebibytes, 1); }

  // Plants, updates, takes what ended, closes the gaps; returns what is left.
  static std::vector<SeedState> DoAll(const std::vector<PosedFrame>& frames, Backend* backend) {
    SceneRange range;
    range.near = 0.7;
    range.far = 1.6;
    const PosedFrame &ref = frames[0], &cur = frames[1];
    const ImageView<std::uint8_t> first[] = {ref.picture->grey.view()};
    backend->SetFrame(first);
    const std::size_t born = backend->Plant({{ref.camera, ref.cam_from_world}, &range, {}, {}})[0];
    const ImageView<std::uint8_t> second[] = {cur.picture->grey.view()};
    backend->SetFrame(second);
    const SeedGroup groups[] = {
        {0,
         born,
         0,
         MakeRelativeView<float>(ref.camera, ref.cam_from_world, cur.camera, cur.cam_from_world),
         static_cast<float>(1 / ref.camera.FocalLength())}};
    backend->Update(groups, cur.camera.model);
    const std::size_t ended = backend->TakeEnded().size();
    EXPECT_GT(ended, 0U);
    EXPECT_LT(ended, born);
    backend->Compact();
    return backend->Read(0, born - ended, 1);
  }

  std::string before_;  // what the variable was

  static Options EndingSoon() {
    Options options = TestOptions();
    options.max_seeds = 20'000;
    options.max_age = 1;
    options.min_views = 200;
    return options;
  }
};

TEST_F(EmulatedGpu, IsThereWhereTheVariableIsSet) {
  ASSERT_EQ(FindCudaDevices().devices.size(), 1U);
  EXPECT_TRUE(FindCudaDevices().devices[0].trouble.empty());
  ::unsetenv(kEmulatedGpuVariable);
  EXPECT_TRUE(FindCudaDevices().devices.empty());
  EXPECT_EQ(FindCudaDevices().trouble, "no NVIDIA driver is installed");
}

TEST_F(EmulatedGpu, ThatIsTooSmallSaysSoAndAutoTakesTheCpu) {
  SetMemory("8");
  Options options = TestOptions();
  options.max_seeds = 1'000'000;
  try {
    MakeCudaBackend(options);
    FAIL() << "a million seeds in 8 MiB";
  } catch (const DeviceError& error) {
    EXPECT_NE(std::string(error.what()).find("8 MiB of memory"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("--seeds"), std::string::npos) << error.what();
  }
  options.backend = BackendChoice::kAuto;
  EXPECT_TRUE(MakeBackend(options)->name().starts_with("CPU"));
  options.max_seeds = 10'000;
  EXPECT_TRUE(MakeBackend(options)->name().starts_with("CUDA")) << "what was taken is given back";
}

TEST_F(EmulatedGpu, GivesTheSameWhenItWorksEarlyOrLate) {
  const auto frames = PlaneScene().Render(SidewaysPath(2));
  const std::vector<SeedState> late = DoAll(frames, MakeCudaBackend(EndingSoon()).get());
  emulated_cuda::WorkAtOnce(true);
  const std::vector<SeedState> early = DoAll(frames, MakeCudaBackend(EndingSoon()).get());
  EXPECT_FALSE(late.empty());
  EXPECT_TRUE(std::ranges::equal(early, late, [](const SeedState& a, const SeedState& b) {
    return a.posterior.mu == b.posterior.mu && a.posterior.sigma2 == b.posterior.sigma2 &&
           a.counts.age == b.counts.age && a.fate == b.fate;
  }));
}

TEST_F(EmulatedGpu, ThatIsLostAtAnyMomentIsAnError) {
  const auto frames = PlaneScene().Render(SidewaysPath(2));
  const int before = emulated_cuda::Operations();
  DoAll(frames, MakeCudaBackend(EndingSoon()).get());
  const int operations = emulated_cuda::Operations() - before;
  ASSERT_GT(operations, 20);
  for (int lost_at = 0; lost_at < operations; ++lost_at) {
    emulated_cuda::LoseDeviceAfter(lost_at);
    EXPECT_THROW(DoAll(frames, MakeCudaBackend(EndingSoon()).get()), DeviceError) << lost_at;
  }
  emulated_cuda::LoseDeviceAfter(-1);
  EXPECT_FALSE(DoAll(frames, MakeCudaBackend(EndingSoon()).get()).empty()) << "nothing stays";
}

}  // namespace
}  // namespace livemvs
