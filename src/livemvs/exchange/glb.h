#pragma once

#include <filesystem>

#include "livemvs/exchange/model.h"

namespace livemvs {

/// Which axis of the world points up.
enum class UpAxis { kZ, kY, kMinusY };

struct GlbOptions {
  UpAxis up = UpAxis::kZ;
  bool draco = false;      ///< Compress the mesh (KHR_draco_mesh_compression); not for clouds.
  int position_bits = 16;  ///< Of Draco's positions, over the longest side of the mesh; 8 ... 24.
};

/// Writes binary glTF 2.0: a mesh as triangles, a cloud as points, with normals and colours.
///
/// glTF's y axis points up and its unit is the metre: coordinates stay those of the world, and the
/// node's rotation turns its up axis to y. Where the model lies far from the origin for its size,
/// positions are relative to its middle, which is the node's translation, so that float32
/// suffices. Colours are linear as glTF demands, in 16 bits, which keep all 256 levels of sRGB
/// apart. The file appears whole or not at all.
/// @throws Error (kOutOfResource) where the file cannot be written or would exceed 4 GiB;
/// std::invalid_argument as ExchangeModel::Check(), and for Draco with a cloud.
void WriteGlb(const std::filesystem::path& path,
              const ExchangeModel& model,
              const GlbOptions& options = {});

/// Reads back what WriteGlb() wrote without Draco, in the coordinates of the world that was
/// written: of those that other programs write glTF is a tree of parts, each turned and scaled,
/// whose world has lost its own axes.
/// @throws Error (kBadInput) naming the file and what is wrong with it.
ExchangeModel ReadGlb(const std::filesystem::path& path);

}  // namespace livemvs
