#pragma once

#include <filesystem>

#include "livemvs/exchange/model.h"

namespace livemvs {

/// Writes a mesh as Wavefront OBJ, `v x y z r g b` with colours in sRGB, 0 ... 1, `vn` and `f`, and
/// beside it the material file of the same name that ends with .mtl. Both appear, or neither.
/// @throws Error (kOutOfResource) where a file cannot be written; std::invalid_argument as
/// ExchangeModel::Check(), for a cloud, and for a name that the format cannot hold.
void WriteObj(const std::filesystem::path& path, const ExchangeModel& model);

}  // namespace livemvs
