#pragma once

#include <cstdint>
#include <string>

#include "livemvs/synth/scene.h"

namespace livemvs::synth {

bool HasScene(const std::string& name);

/// "table, relief, ..." for messages.
std::string SceneNames();

/// Builds a scene by its name, which must exist.
SceneDescription DescribeScene(const SceneOptions& options);

/// Adds materials and shapes to a description.
class SceneWriter {
 public:
  SceneWriter(SceneDescription* scene, std::uint64_t seed)
      : scene_(scene), seed_(seed), builder_(&scene->mesh) {}

  /// Shapes that follow are of this material.
  void Use(Material material);

  /// Shapes that follow are in a frame at (x, y, z), turned about z [degrees].
  void Place(double x, double y, double z, double turn_deg);

  MeshBuilder* operator->() { return &builder_; }

 private:
  SceneDescription* scene_;
  std::uint64_t seed_;
  MeshBuilder builder_;
};

/// Wood with rings of this width [m].
Material WoodMaterial(const char* name, float scale);

/// Speckled stone: the sheet under the objects.
Material SheetMaterial();

/// A table top of planks under everything, its surface at height z.
void AddTableTop(SceneWriter& writer, float length, float width, float z);

/// A house with gabled roof, chimney, door and windows on the ground z = 0 of the current frame.
/// @param size  Length, width and height of the walls [m].
void AddHouse(SceneWriter& writer, const Eigen::Vector3f& size);

/// Six solids on z = 0.
void AddStillLife(SceneWriter& writer);

void DescribeTable(SceneWriter& writer, SceneDescription* scene);
void DescribeHouse(SceneWriter& writer, SceneDescription* scene);
void DescribeRelief(SceneWriter& writer, SceneDescription* scene);
void DescribeRoom(SceneWriter& writer, SceneDescription* scene);
void DescribePlane(SceneWriter& writer, SceneDescription* scene);
void DescribeHazards(SceneWriter& writer, SceneDescription* scene);
void DescribeBench(SceneWriter& writer, SceneDescription* scene);
void DescribeSheet(SceneWriter& writer, SceneDescription* scene);
void DescribeBoard(SceneWriter& writer, SceneDescription* scene);

}  // namespace livemvs::synth
