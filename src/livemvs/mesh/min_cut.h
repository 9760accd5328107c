#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace livemvs {

/// The minimum cut of a graph whose nodes are linked to each other and to a source and a sink, by
/// augmenting paths between two search trees that are kept from path to path (Boykov & Kolmogorov,
/// "An experimental comparison of min-cut/max-flow algorithms for energy minimization in vision",
/// 2004). Fast where, as in grids, nearly every node is linked to a terminal. Capacities are
/// integers: the result is exact, and depends on nothing but the order of the calls.
class MinCut {
 public:
  using Node = std::int32_t;

  /// @param nodes, links  As many as will be added at most; memory for both is reserved.
  explicit MinCut(std::size_t nodes, std::size_t links = 0);

  /// Links two different nodes. @param forth, back  Capacities from a to b, and back; >= 0.
  void AddLink(Node a, Node b, std::int32_t forth, std::int32_t back);

  /// Adds capacities from the source and to the sink; both >= 0.
  void AddTerminal(Node node, std::int64_t source, std::int64_t sink);

  /// The value of the cut. Call it once, after all links.
  std::int64_t Solve();

  /// Whether the node stays with the source. Nodes that belong to neither side are the sink's.
  bool InSource(Node node) const { return tree_[Index(node)] == Tree::kSource; }

  std::size_t size() const { return excess_.size(); }

 private:
  enum class Tree : std::uint8_t { kNone, kSource, kSink };
  using Arc = std::int32_t;

  static constexpr Arc kNoParent = -1, kTerminal = -2;
  static std::size_t Index(std::int32_t i) { return static_cast<std::size_t>(i); }
  // Arcs come in pairs; the other direction of arc a is a ^ 1.
  Node Head(Arc a) const { return head_[Index(a)]; }
  Node Tail(Arc a) const { return head_[Index(a ^ 1)]; }
  std::int32_t TowardsSink(Tree tree, Arc from_node) const;

  void SortArcs();
  void PlantTrees();
  Arc Grow();
  void GrowNode(Node node, Arc* found);
  std::int64_t Bottleneck(Arc middle) const;
  void Augment(Arc middle);
  void Adopt();
  void AdoptOne(Node node);
  bool Rooted(Node node);
  void Activate(Node node);
  void MakeOrphan(Node node);

  std::vector<Node> head_;               // of each arc
  std::vector<std::int32_t> residual_;   // of each arc
  std::vector<Arc> arcs_;                // by node
  std::vector<std::int32_t> first_arc_;  // of each node in arcs_, and the end
  std::vector<std::int64_t> excess_;     // > 0: left from the source, < 0: left to the sink
  std::vector<Tree> tree_;
  std::vector<Arc> parent_;             // arc from the node to its parent
  std::vector<std::int32_t> distance_;  // to the terminal, right at the time of its stamp
  std::vector<std::int32_t> stamp_;
  std::vector<char> queued_;
  std::vector<Node> active_, next_active_;
  std::size_t active_at_ = 0;
  std::vector<Node> orphans_;
  std::size_t orphans_at_ = 0;
  std::int32_t time_ = 0;
  std::int64_t flow_ = 0;
};

}  // namespace livemvs
