#pragma once

#include <filesystem>
#include <string>

#include "livemvs/exchange/model.h"

namespace livemvs {

struct LasOptions {
  std::string crs_wkt;  ///< Coordinate system in OGC WKT; empty: none is stated.
};

/// Writes a cloud as LAS 1.4, point format 7: positions, 16-bit colours, and as extra bytes sigma,
/// inlier_ratio, views (and nx, ny, nz where there are normals), each described in the file.
/// Positions are whole multiples of a power of ten, a hundred-millionth of the cloud's longest side
/// or less, which is as fine as float32 there. GPS time is 0. The file appears whole or not at all.
/// @throws Error (kOutOfResource) where the file cannot be written; std::invalid_argument as
/// ExchangeModel::Check(), for a mesh, and for a description of more than 65534 bytes.
void WriteLas(const std::filesystem::path& path,
              const ExchangeModel& model,
              const LasOptions& options = {});

}  // namespace livemvs
