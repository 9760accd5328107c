#include "livemvs/synth/scene_builders.h"

#include <Eigen/Geometry>
#include <array>
#include <numbers>
#include <string_view>
#include <utility>

#include "livemvs/synth/random.h"

namespace livemvs::synth {
namespace {

using Describe = void (*)(SceneWriter&, SceneDescription*);

constexpr std::array<std::pair<std::string_view, Describe>, 9> kScenes{{
    {"table", DescribeTable},
    {"relief", DescribeRelief},
    {"house", DescribeHouse},
    {"room", DescribeRoom},
    {"plane", DescribePlane},
    {"hazards", DescribeHazards},
    {"bench", DescribeBench},
    {"sheet", DescribeSheet},
    {"board", DescribeBoard},
}};

}  // namespace

bool HasScene(const std::string& name) {
  for (const auto& scene : kScenes) {
    if (scene.first == name) return true;
  }
  return false;
}

std::string SceneNames() {
  std::string names;
  for (const auto& scene : kScenes) {
    if (!names.empty()) names += ", ";
    names += scene.first;
  }
  return names;
}

SceneDescription DescribeScene(const SceneOptions& options) {
  SceneDescription scene;
  scene.sheet = options.sheet;
  scene.background_low = FromSrgb(0x8E8A84);
  scene.background_high = FromSrgb(0xC9CDD2);
  SceneWriter writer(&scene, options.seed);
  for (const auto& [scene_name, describe] : kScenes) {
    if (scene_name == options.name) describe(writer, &scene);
  }
  return scene;
}

void SceneWriter::Use(Material material) {
  Random random(seed_ * 1000 + scene_->materials.size());
  for (int i = 0; i < 3; ++i) material.shift[i] = static_cast<float>(random.Uniform(5, 9));
  scene_->materials.push_back(std::move(material));
  builder_.Use(static_cast<std::uint8_t>(scene_->materials.size() - 1));
}

void SceneWriter::Place(double x, double y, double z, double turn_deg) {
  const Eigen::AngleAxisd turn(turn_deg * std::numbers::pi / 180, Eigen::Vector3d::UnitZ());
  builder_.Place({turn.toRotationMatrix(), Eigen::Vector3d(x, y, z)});
}

}  // namespace livemvs::synth
