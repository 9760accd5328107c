#include "livemvs/backend/cuda/cuda_backend.h"

#include <algorithm>
#include <cstring>

#include "livemvs/backend/cuda/device_memory.h"
#include "livemvs/backend/cuda/device_planter.h"
#include "livemvs/backend/cuda/device_seeds.h"
#include "livemvs/backend/cuda/seed_kernels.h"

namespace livemvs {
namespace cuda {
namespace {

/// A pyramid on the device. Rows start at multiples of kAlignment; the kernels read some bytes past
/// the end.
class DevicePyramid {
 public:
  /// Begins to copy it there; `grey` may go at once. Nothing may still use the pyramid before.
  void Upload(std::span<const ImageView<std::uint8_t>> grey, const Stream& stream) {
    std::size_t pixels = 0;
    for (const auto& level : grey) pixels += SizeOf(level);
    std::uint8_t* staging = grey_.Fill(pixels + kAlignment);
    pairs_.Reserve(pixels + kAlignment);
    CurrentImage* images = images_.Fill(grey.size());
    std::size_t begin = 0;
    for (std::size_t l = 0; l < grey.size(); ++l) {
      const ImageView<std::uint8_t>& level = grey[l];
      const std::ptrdiff_t stride = StrideOf(level);
      for (int y = 0; y < level.height; ++y) {
        std::memcpy(staging + begin + y * stride, level.Row(y), level.width);
      }
      images[l] = {{grey_.device() + begin, level.width, level.height, stride},
                   {pairs_.get() + begin, level.width, level.height, stride}};
      begin += SizeOf(level);
    }
    grey_.Upload(pixels + kAlignment, stream);
    Check(
        cudaMemsetAsync(pairs_.get() + pixels, 0, kAlignment * sizeof(std::uint16_t), stream.get()),
        "clear the end of a picture");
    for (std::size_t l = 0; l < grey.size(); ++l) {
      if (WarpRule::Allows(grey[l].width, grey[l].height)) {
        LaunchBuildPairs(
            images[l].grey, const_cast<std::uint16_t*>(images[l].pairs.data), stream.get());
      }
    }
    images_.Upload(grey.size(), stream);
    levels_ = grey.size();
  }

  /// The levels, for the host to look at and for the device; pixels are on the device.
  std::span<const CurrentImage> levels() const { return {images_.host(), levels_}; }
  const CurrentImage* on_device() const { return images_.device(); }

 private:
  static constexpr int kAlignment = 128;

  static std::ptrdiff_t StrideOf(const ImageView<std::uint8_t>& image) {
    return (image.width + kAlignment - 1) / kAlignment * kAlignment;
  }
  static std::size_t SizeOf(const ImageView<std::uint8_t>& image) {
    return static_cast<std::size_t>(StrideOf(image)) * image.height;
  }

  Table<std::uint8_t> grey_;
  DeviceArray<std::uint16_t> pairs_;
  Table<CurrentImage> images_;
  std::size_t levels_ = 0;
};

class CudaBackend final : public Backend {
 public:
  CudaBackend(const Options& options, std::string device)
      : options_(options),
        warp_rule_(options),
        device_(std::move(device)),
        seeds_(static_cast<std::size_t>(options.max_seeds), &stream_),
        planter_(options_, &stream_),
        totals_on_host_(1) {
    *options_on_device_.Fill(1) = options;
    new (is_outlier_.Fill(1)) OutlierRule(options.eta_outlier, options.outlier_certainty);
    options_on_device_.Upload(1, stream_);
    is_outlier_.Upload(1, stream_);
    totals_.Reserve(1);
  }

  std::string name() const override { return "CUDA, " + device_; }

  std::size_t capacity() const override { return seeds_.capacity(); }

  void SetFrame(std::span<const ImageView<std::uint8_t>> pyramid) override {
    stream_.Wait("finish before the next frame");
    pyramid_.Upload(pyramid, stream_);
  }

  UpdateStatistics Update(std::span<const SeedGroup> groups, CameraModel model) override {
    const KernelArguments common = UploadGroups(groups);
    if (common.block_count == 0) return {};
    Check(cudaMemsetAsync(totals_.get(), 0, sizeof(StatusTotals), stream_.get()), "clear sums");
    LaunchUpdate({common, pyramid_.on_device(), ChooseWarp(groups, common), totals_.get()},
                 model,
                 stream_.get());
    Copy(totals_.get(), totals_on_host_.get(), 1, stream_);
    seeds_.SelectEnded();
    stream_.Wait("update seeds");
    const auto total = [&](MatchStatus status) {
      return static_cast<std::int64_t>((*totals_on_host_.get())[static_cast<int>(status)]);
    };
    UpdateStatistics statistics;
    statistics.matched = total(MatchStatus::kMatched);
    statistics.no_information = total(MatchStatus::kNoInformation);
    statistics.out_of_view = total(MatchStatus::kOutOfView);
    statistics.mismatched = total(MatchStatus::kMismatch);
    return statistics;
  }

  std::span<const EndedSeed> TakeEnded() override { return seeds_.TakeEnded(); }

  void Compact() override { seeds_.Compact(); }

  std::vector<std::size_t> Plant(const Planting& planting) override {
    return planter_.Plant(planting, pyramid_.levels(), UploadGroups(planting.groups), &seeds_);
  }

  void ForgetPoints() override { planter_.ForgetPoints(); }

  std::vector<SeedState> Read(std::size_t begin, std::size_t end, std::size_t step) override {
    return seeds_.Read(begin, end, step);
  }

  std::vector<std::uint8_t> ReadPatches(std::size_t begin, std::size_t end) override {
    return seeds_.ReadPatches(begin, end);
  }

 private:
  // Begins to copy the groups, and which of their seeds are for which block of threads.
  KernelArguments UploadGroups(std::span<const SeedGroup> groups) {
    std::size_t count = 0;
    for (const SeedGroup& group : groups) {
      count += (group.end - group.begin + kSeedsPerBlock - 1) / kSeedsPerBlock;
    }
    KernelArguments arguments = {options_on_device_.device(),
                                 is_outlier_.device(),
                                 seeds_.columns(),
                                 nullptr,
                                 nullptr,
                                 static_cast<unsigned>(count)};
    if (count == 0) return arguments;
    SeedBlock* block = blocks_.Fill(count);
    for (std::uint32_t g = 0; g < groups.size(); ++g) {
      const auto end = static_cast<std::uint32_t>(groups[g].end);
      for (auto at = static_cast<std::uint32_t>(groups[g].begin); at < end; at += kSeedsPerBlock) {
        *block++ = {g, at, std::min(at + kSeedsPerBlock, end)};
      }
    }
    std::ranges::copy(groups, groups_.Fill(groups.size()));
    arguments.groups = groups_.Upload(groups.size(), stream_);
    arguments.blocks = blocks_.Upload(count, stream_);
    return arguments;
  }

  // Begins to decide which groups' sampling grids follow the relative pose.
  const Warp* ChooseWarp(std::span<const SeedGroup> groups, const KernelArguments& common) {
    Warp* warp = warp_.Fill(groups.size());
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const ImageView<std::uint8_t>& image =
          pyramid_.levels()[static_cast<std::size_t>(groups[g].level)].grey;
      warp[g] = !WarpRule::Allows(image.width, image.height) ? Warp::kNo
                : warp_rule_.Turned(groups[g].view)          ? Warp::kYes
                                                             : Warp::kAskScale;
    }
    warp_.Upload(groups.size(), stream_);
    LaunchChooseWarp(warp_rule_,
                     common.seeds,
                     common.groups,
                     static_cast<unsigned>(groups.size()),
                     warp_.device(),
                     stream_.get());
    return warp_.device();
  }

  Options options_;
  WarpRule warp_rule_;
  std::string device_;
  Stream stream_;
  DeviceSeeds seeds_;
  DevicePlanter planter_;
  Table<Options> options_on_device_;
  Table<OutlierRule> is_outlier_;
  Table<SeedGroup> groups_;
  Table<SeedBlock> blocks_;
  Table<Warp> warp_;
  DevicePyramid pyramid_;
  DeviceArray<StatusTotals> totals_;
  PinnedArray<StatusTotals> totals_on_host_;
};

// Why the kernels do not run on a device; empty: they do.
std::string TroubleWith(const cudaDeviceProp& properties) {
  constexpr int kLeastMajor = 7, kLeastMinor = 5;
  if (properties.major > kLeastMajor ||
      (properties.major == kLeastMajor && properties.minor >= kLeastMinor)) {
    return {};
  }
  return "its compute capability is below 7.5";
}

}  // namespace
}  // namespace cuda

CudaDevices FindCudaDevices() {
  CudaDevices found;
  int count = 0;
  const cudaError_t status = cudaGetDeviceCount(&count);
  if (status != cudaSuccess || count == 0) {
    cudaGetLastError();  // it does not stay
    int driver = 0;
    cudaDriverGetVersion(&driver);
    found.trouble = driver == 0             ? "no NVIDIA driver is installed"
                    : status != cudaSuccess ? cudaGetErrorString(status)
                                            : "no CUDA device";
    return found;
  }
  for (int i = 0; i < count; ++i) {
    cudaDeviceProp properties;
    if (cudaGetDeviceProperties(&properties, i) != cudaSuccess) {
      cudaGetLastError();
      continue;
    }
    found.devices.push_back({properties.name,
                             properties.major,
                             properties.minor,
                             properties.totalGlobalMem,
                             cuda::TroubleWith(properties)});
  }
  return found;
}

std::unique_ptr<Backend> MakeCudaBackend(const Options& options) {
  const CudaDevices found = FindCudaDevices();
  if (found.devices.empty()) throw DeviceError("GPU: " + found.trouble);
  const CudaDevice& device = found.devices.front();
  if (!device.trouble.empty()) {
    throw DeviceError("GPU: " + device.name + ": " + device.trouble +
                      "; if there is another, name it in CUDA_VISIBLE_DEVICES");
  }
  return std::make_unique<cuda::CudaBackend>(options, device.name);
}

}  // namespace livemvs
