#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>

#include "livemvs/core/frame.h"

namespace livemvs::synth {

class PrintedSheet;

/// Solid textures: functions of the place in the object.
enum class Texture : std::uint8_t {
  kPlain,     ///< One colour, no texture.
  kClouds,    ///< Fractal noise between the colours.
  kWood,      ///< Grain along x.
  kParquet,   ///< Wooden planks along x.
  kBrick,     ///< Courses of bricks on walls.
  kTiles,     ///< Rows of roof tiles.
  kStone,     ///< Grainy stone with veins.
  kTerrazzo,  ///< Chips of stone in cement.
  kMarble,    ///< Veins.
  kGlaze,     ///< Painted bands along z under a speckled glaze.
  kPrint,     ///< Blots of many sizes, as of printed paper.
  kStripes,   ///< Equal stripes along the horizontal of flat faces, with nothing else.
  kWeave,     ///< Threads over and under each other, on flat faces.
  kText,      ///< Lines of printed words, on flat faces.
  kDots,      ///< Round spots of many sizes.
  kBrushed,   ///< Fine lines along x, as of brushed metal or the edges of pages.
  kPrinted,   ///< `printed` on the upper side: `base` the paper, `second` the ink.
};

/// What a surface is made of. Colours are linear reflectances, 0 to 1.
struct Material {
  std::string name;
  Texture texture = Texture::kPlain;
  Eigen::Vector3f base = Eigen::Vector3f::Constant(0.5f);
  Eigen::Vector3f second = Eigen::Vector3f::Constant(0.5f);
  Eigen::Vector3f accent = Eigen::Vector3f::Constant(0.5f);
  float scale = 0.02f;    ///< Size of the texture's main features [m].
  float contrast = 0.5f;  ///< Of the fine grain.
  /// Share of the light that is mirrored straight on, growing to 1 along the surface: glazed
  /// ceramics 0.05, polished metal 0.6; 0: matt, the same from everywhere.
  float gloss = 0;
  std::shared_ptr<const PrintedSheet> printed;  ///< Of kPrinted.
  bool textureless = false;
  bool repetitive = false;
  Eigen::Vector3f shift = Eigen::Vector3f::Zero();  ///< Of the noise; from the scene's seed.
};

/// Linear reflectance of 0xRRGGBB in sRGB.
Eigen::Vector3f FromSrgb(std::uint32_t rgb);

/// The nearest sRGB colour of a linear one, clamped.
Rgb ToSrgb(const Eigen::Vector3f& linear);

/// The value on sRGB's scale of a linear one in [0, 1], times 255, not rounded.
float ToSrgbLevel(float linear);

/// The colour of a surface.
/// @param p          Place in the object [m].
/// @param normal     Unit normal in the object, of the flat face.
/// @param footprint  Width of a pixel there [m]; finer detail fades out.
Eigen::Vector3f Reflectance(const Material& material,
                            const Eigen::Vector3f& p,
                            const Eigen::Vector3f& normal,
                            float footprint);

}  // namespace livemvs::synth
