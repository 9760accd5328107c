#include "livemvs/backend/cpu/planter.h"

#include "livemvs/parallel/parallel_for.h"

namespace livemvs {

std::vector<std::size_t> Planter::Plant(const Planting& planting,
                                        std::span<const ImageView<std::uint8_t>> pyramid,
                                        HostSeeds* seeds) {
  coverage_.Reset(pyramid);
  if (options_.cover_radius_px >= 0) MarkKnown(planting, seeds->columns());
  std::vector<std::size_t> planted(pyramid.size());
  // Coarse seeds first: they are few.
  for (std::size_t l = pyramid.size(); l-- > 0;) {
    planted[l] = PlantLevel(planting, static_cast<int>(l), pyramid[l], seeds);
  }
  return planted;
}

void Planter::MarkKnown(const Planting& planting, const SeedColumns& seeds) {
  constexpr std::size_t kSeedsToMark = 2048;
  for (const SeedGroup& group : planting.groups) {
    const MarkJob job = {options_.coordinate,
                         seeds,
                         &group,
                         planting.frame.camera.model,
                         coverage_.marks()[static_cast<std::size_t>(group.level)]};
    ParallelForRange(
        group.begin, group.end, kSeedsToMark, [&](std::size_t first, std::size_t last) {
          mark_(job, first, last);
        });
  }
  coverage_.MarkPoints(planting.frame, planting.points);
}

std::size_t Planter::PlantLevel(const Planting& planting,
                                int level,
                                const ImageView<std::uint8_t>& grey,
                                HostSeeds* seeds) {
  candidates_.Find(grey,
                   coverage_.marks()[static_cast<std::size_t>(level)].view(),
                   MakeCandidateRule(options_, planting, level));
  const PlantView view = MakePlantView(options_, planting, level, grey);
  return VisitModel(planting.frame.camera.model, [&](auto model) {
    return PlantInRounds(candidates_.count(), seeds->room(), [&](const Share& share, std::size_t) {
      return PlantShare<decltype(model)>(view, share, seeds);
    });
  });
}

template <typename Model>
std::size_t Planter::PlantShare(const PlantView& view, const Share& share, HostSeeds* seeds) {
  constexpr std::size_t kOffersAtOnce = 8192;
  std::size_t rank = 0, planted = 0;
  offers_.clear();  // of a planting that failed
  candidates_.ForEach(share.first, share.whole, [&](int x, int y, int phase) {
    if (!share.Offers(phase, phase == share.whole ? rank++ : 0)) return;
    candidates_.Take(x, y);
    offers_.push_back({x, y, false, {}});
    if (offers_.size() == kOffersAtOnce) planted += PlantOffers<Model>(view, seeds);
  });
  return planted + PlantOffers<Model>(view, seeds);
}

// Those that find no room any more are lost: the level is done.
template <typename Model>
std::size_t Planter::PlantOffers(const PlantView& view, HostSeeds* seeds) {
  constexpr std::size_t kOffersPerTask = 256;
  if (seeds->room() == 0) offers_.clear();
  ParallelForRange(0, offers_.size(), kOffersPerTask, [&](std::size_t first, std::size_t last) {
    for (Offer& o : std::span(offers_).subspan(first, last - first)) {
      o.gives_seed = SeedAt<Model>(options_, view, o.x, o.y, &o.seed);
    }
  });
  const Posterior<float> prior = PriorOf(options_);
  std::size_t planted = 0;
  for (const Offer& o : offers_) {
    if (!o.gives_seed) continue;
    if (seeds->room() == 0) break;
    seeds->Append(o.seed, prior);
    ++planted;
  }
  offers_.clear();
  return planted;
}

}  // namespace livemvs
