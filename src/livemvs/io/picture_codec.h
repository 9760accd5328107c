#pragma once

#include <cstdint>
#include <filesystem>

#include "livemvs/core/frame.h"
#include "livemvs/core/image.h"

namespace livemvs {

/// Decodes a PNG, JPEG, PGM or PPM file, 8 or 16 bits, grey or colour; alpha is ignored. What the
/// file is shows from its first bytes, not its name. JPEG keeps its own luma and chroma planes;
/// colour otherwise becomes full-range BT.601 without sub-sampling; 16 bits become 8. An
/// orientation in the metadata is not applied, because calibrations refer to the pixels as stored.
/// @throws Error (kBadInput) naming the file where it is missing, damaged, cut short, of another
/// kind, or larger than 16384 x 16384.
Picture ReadPicture(const std::filesystem::path& path);

/// Reads a 16-bit grey PNG or PGM as it is: the depth images of RGB-D cameras. 8-bit ones are read
/// too, with their own values.
/// @throws Error (kBadInput) as ReadPicture, and where the picture is not grey.
Image<std::uint16_t> ReadDepthPng(const std::filesystem::path& path);

/// Writes an 8-bit PNG. The file appears whole or not at all.
/// @throws Error (kOutOfResource) where the file cannot be written; std::invalid_argument for an
/// empty image.
void WritePng(const std::filesystem::path& path, const Image<std::uint8_t>& grey);
void WritePng(const std::filesystem::path& path, const Image<Rgb>& rgb);

/// Writes a 16-bit grey PNG, as ReadDepthPng reads it.
void WritePng(const std::filesystem::path& path, const Image<std::uint16_t>& depth);

}  // namespace livemvs
