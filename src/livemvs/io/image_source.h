#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "livemvs/io/frame_source.h"

namespace livemvs {

/// The images of a folder (.png, .jpg, .jpeg, .pgm, .ppm, .pnm in any case; hidden files and
/// sub-folders left out), numbers in their names in numeric order: img2 before img10.
/// @throws Error (kBadInput) where there is no such folder.
std::vector<std::filesystem::path> ListImages(const std::filesystem::path& folder);

/// Whether the name ends as one of the kinds of images that ListImages looks for.
bool HasImageExtension(const std::filesystem::path& path);

/// Whether a comes before b where runs of digits compare as numbers.
bool NaturalLess(const std::string& a, const std::string& b);

/// Reads image files in the order given. Unreadable ones are passed over and counted;
/// `SourceFrame::index` is the position in `files`, `timestamp` is index / frames_per_second.
/// @throws Error (kBadInput) where `files` is empty or none of them can be read.
std::unique_ptr<FrameSource> OpenImages(std::vector<std::filesystem::path> files,
                                        double frames_per_second = 30);

}  // namespace livemvs
