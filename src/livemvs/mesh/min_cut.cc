#include "livemvs/mesh/min_cut.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace livemvs {

MinCut::MinCut(std::size_t nodes, std::size_t links) {
  constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max() / 2;
  if (nodes > kMost || links > kMost) {
    throw std::invalid_argument("MinCut: too many nodes or links: " + std::to_string(nodes) + ", " +
                                std::to_string(links));
  }
  excess_.resize(nodes, 0);
  head_.reserve(2 * links);
  residual_.reserve(2 * links);
}

void MinCut::AddLink(Node a, Node b, std::int32_t forth, std::int32_t back) {
  head_.push_back(b);
  head_.push_back(a);
  residual_.push_back(forth);
  residual_.push_back(back);
}

void MinCut::AddTerminal(Node node, std::int64_t source, std::int64_t sink) {
  // What can flow straight through does so at once.
  std::int64_t& excess = excess_[Index(node)];
  const std::int64_t in = source + std::max<std::int64_t>(excess, 0);
  const std::int64_t out = sink + std::max<std::int64_t>(-excess, 0);
  flow_ += std::min(in, out);
  excess = in - out;
}

void MinCut::SortArcs() {
  first_arc_.assign(size() + 1, 0);
  for (std::size_t a = 0; a < head_.size(); ++a) ++first_arc_[Index(head_[a]) + 1];
  for (std::size_t i = 0; i < size(); ++i) first_arc_[i + 1] += first_arc_[i];
  arcs_.resize(head_.size());
  std::vector<std::int32_t> at(first_arc_.begin(), first_arc_.end() - 1);
  // Arc a ^ 1 leaves where arc a arrives.
  for (std::size_t a = 0; a < head_.size(); ++a) {
    arcs_[Index(at[Index(head_[a])]++)] = static_cast<Arc>(a ^ 1);
  }
}

void MinCut::PlantTrees() {
  const std::size_t n = size();
  tree_.assign(n, Tree::kNone);
  parent_.assign(n, kNoParent);
  distance_.assign(n, 0);
  stamp_.assign(n, 0);
  queued_.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    if (excess_[i] == 0) continue;
    tree_[i] = excess_[i] > 0 ? Tree::kSource : Tree::kSink;
    parent_[i] = kTerminal;
    distance_[i] = 1;
    Activate(static_cast<Node>(i));
  }
}

std::int64_t MinCut::Solve() {
  SortArcs();
  PlantTrees();
  for (Arc middle = Grow(); middle != kNoParent; middle = Grow()) {
    ++time_;
    Augment(middle);
    Adopt();
  }
  return flow_;
}

void MinCut::Activate(Node node) {
  if (queued_[Index(node)] != 0) return;
  queued_[Index(node)] = 1;
  next_active_.push_back(node);
}

/// Residual capacity along an arc of a node, in the direction from the source to the sink.
std::int32_t MinCut::TowardsSink(Tree tree, Arc from_node) const {
  return residual_[Index(tree == Tree::kSource ? from_node : from_node ^ 1)];
}

/// Grows the trees until they touch: an arc from the source's to the sink's, or none.
MinCut::Arc MinCut::Grow() {
  for (;;) {
    if (active_at_ == active_.size()) {
      active_.clear();
      active_at_ = 0;
      std::swap(active_, next_active_);
      if (active_.empty()) return kNoParent;
    }
    const Node node = active_[active_at_];
    Arc found = kNoParent;
    if (tree_[Index(node)] != Tree::kNone) GrowNode(node, &found);
    if (found != kNoParent) return found;  // the node stays active
    queued_[Index(node)] = 0;
    ++active_at_;
  }
}

void MinCut::GrowNode(Node node, Arc* found) {
  const Tree tree = tree_[Index(node)];
  for (std::int32_t k = first_arc_[Index(node)]; k < first_arc_[Index(node) + 1]; ++k) {
    const Arc arc = arcs_[Index(k)];
    if (TowardsSink(tree, arc) <= 0) continue;
    const auto next = Index(Head(arc));
    if (tree_[next] == Tree::kNone) {
      tree_[next] = tree;
      parent_[next] = arc ^ 1;
      distance_[next] = distance_[Index(node)] + 1;
      stamp_[next] = stamp_[Index(node)];
      Activate(Head(arc));
    } else if (tree_[next] != tree) {
      *found = tree == Tree::kSource ? arc : arc ^ 1;
      return;
    } else if (stamp_[next] <= stamp_[Index(node)] &&
               distance_[next] > distance_[Index(node)] + 1) {
      parent_[next] = arc ^ 1;  // a shorter way to the terminal
      distance_[next] = distance_[Index(node)] + 1;
      stamp_[next] = stamp_[Index(node)];
    }
  }
}

std::int64_t MinCut::Bottleneck(Arc middle) const {
  std::int64_t least = residual_[Index(middle)];
  Node node = Tail(middle);
  for (Arc up; (up = parent_[Index(node)]) != kTerminal; node = Head(up)) {
    least = std::min<std::int64_t>(least, residual_[Index(up ^ 1)]);
  }
  least = std::min(least, excess_[Index(node)]);
  node = Head(middle);
  for (Arc up; (up = parent_[Index(node)]) != kTerminal; node = Head(up)) {
    least = std::min<std::int64_t>(least, residual_[Index(up)]);
  }
  return std::min(least, -excess_[Index(node)]);
}

void MinCut::MakeOrphan(Node node) {
  parent_[Index(node)] = kNoParent;
  orphans_.push_back(node);
}

void MinCut::Augment(Arc middle) {
  const std::int64_t amount = Bottleneck(middle);
  const auto delta = static_cast<std::int32_t>(amount);
  flow_ += amount;
  const auto push = [&](Arc a) {
    residual_[Index(a)] -= delta;
    residual_[Index(a ^ 1)] += delta;
    return residual_[Index(a)] == 0;
  };
  push(middle);
  Node node = Tail(middle);
  for (Arc up; (up = parent_[Index(node)]) != kTerminal;) {
    const Node above = Head(up);
    if (push(up ^ 1)) MakeOrphan(node);
    node = above;
  }
  if ((excess_[Index(node)] -= amount) == 0) MakeOrphan(node);
  node = Head(middle);
  for (Arc up; (up = parent_[Index(node)]) != kTerminal;) {
    const Node above = Head(up);
    if (push(up)) MakeOrphan(node);
    node = above;
  }
  if ((excess_[Index(node)] += amount) == 0) MakeOrphan(node);
}

void MinCut::Adopt() {
  for (orphans_at_ = 0; orphans_at_ < orphans_.size(); ++orphans_at_) {
    AdoptOne(orphans_[orphans_at_]);
  }
  orphans_.clear();
}

/// Whether the way up from the node ends at its terminal; notes the distances on the way.
bool MinCut::Rooted(Node node) {
  std::int32_t steps = 0;
  Node top = node;
  while (stamp_[Index(top)] != time_) {
    const Arc up = parent_[Index(top)];
    if (up == kNoParent) return false;
    ++steps;
    if (up == kTerminal) {
      stamp_[Index(top)] = time_;
      distance_[Index(top)] = 1;
      --steps;
      break;
    }
    top = Head(up);
  }
  std::int32_t distance = distance_[Index(top)] + steps;
  while (stamp_[Index(node)] != time_) {
    stamp_[Index(node)] = time_;
    distance_[Index(node)] = distance--;
    node = Head(parent_[Index(node)]);
  }
  return true;
}

/// Finds another parent for the node, or sets it free.
void MinCut::AdoptOne(Node node) {
  const std::size_t n = Index(node);
  const Tree tree = tree_[n];
  Arc best = kNoParent;
  std::int32_t best_distance = std::numeric_limits<std::int32_t>::max();
  for (std::int32_t k = first_arc_[n]; k < first_arc_[n + 1]; ++k) {
    const Arc arc = arcs_[Index(k)];
    const Node other = Head(arc);
    if (tree_[Index(other)] != tree || TowardsSink(tree, arc ^ 1) <= 0) continue;
    if (!Rooted(other) || distance_[Index(other)] >= best_distance) continue;
    best = arc;
    best_distance = distance_[Index(other)];
  }
  if (best != kNoParent) {
    parent_[n] = best;
    stamp_[n] = time_;
    distance_[n] = best_distance + 1;
    return;
  }
  stamp_[n] = 0;
  tree_[n] = Tree::kNone;
  for (std::int32_t k = first_arc_[n]; k < first_arc_[n + 1]; ++k) {
    const Arc arc = arcs_[Index(k)];
    const Node other = Head(arc);
    if (tree_[Index(other)] != tree) continue;
    if (TowardsSink(tree, arc ^ 1) > 0) Activate(other);
    const Arc up = parent_[Index(other)];
    if (up >= 0 && Head(up) == node) MakeOrphan(other);
  }
}

}  // namespace livemvs
