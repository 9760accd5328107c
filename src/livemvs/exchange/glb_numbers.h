#pragma once

#include <cstdint>

namespace livemvs::glb {

// Numbers of the specification of glTF 2.0: of the file and its chunks, ...
inline constexpr std::uint32_t kMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinChunk = 0x004E4942;

// ... and of what the components of an accessor are.
inline constexpr int kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;

}  // namespace livemvs::glb
