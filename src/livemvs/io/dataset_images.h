#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "livemvs/io/dataset.h"

namespace livemvs {

/// One image of a data set as its files state it, in our conventions.
struct ImageEntry {
  std::string name;            ///< As written in the files; a path relative to the image folder.
  std::string place;           ///< "file:line" that names the image.
  std::filesystem::path file;  ///< Filled by OpenImageSet where empty.
  std::int64_t number = -1;    ///< Position in the source; -1: OpenImageSet counts.
  std::optional<double> timestamp;  ///< [s]; without one, number / 30.
  Camera camera;                    ///< width = height = 0 where the files do not state the size.
  Rigid3d cam_from_world;
};

/// What the reader of one format finds.
struct ImageSet {
  std::string format;                  ///< For people: "COLMAP text model".
  std::filesystem::path file;          ///< The file that defines it, for messages.
  std::filesystem::path root;          ///< Images must lie below it.
  std::filesystem::path image_folder;  ///< Names are relative to it; below `root`.
  std::vector<ImageEntry> images;      ///< In any order.
  bool keep_order = false;             ///< As listed (in time), not by name.
  std::vector<Eigen::Vector3d> sparse_points;
  std::optional<Box> box;
  std::int64_t unposed = 0;  ///< Images that the files list without a usable pose.
};

/// Orders the images by name, finds their files, leaves out missing ones (one warning that counts
/// them), and gives them out as a data set.
/// @throws Error (kBadInput) where a path climbs out of the folder, where fewer than two images
/// remain, or where the first image's size is not the calibration's.
std::unique_ptr<Dataset> OpenImageSet(ImageSet set, const DatasetOptions& options);

/// @throws Error (kBadInput) where fewer than two frames are left. `found` says what is there:
/// "COLMAP text model with 12 images, 11 of them missing".
void RequireTwoFrames(std::size_t usable,
                      const std::filesystem::path& place,
                      const std::string& found);

/// Whether a frame is chosen by first_frame, last_frame and step.
bool IsChosen(const DatasetOptions& options, std::int64_t index);

/// @throws std::invalid_argument where first_frame, last_frame or step make no sense.
void CheckRange(const DatasetOptions& options);

/// What OpenDataset understands, for messages.
std::string SupportedForms();

}  // namespace livemvs
