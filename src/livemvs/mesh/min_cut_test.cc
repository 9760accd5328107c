#include "livemvs/mesh/min_cut.h"

#include <gtest/gtest.h>
#include <lemon/preflow.h>
#include <lemon/smart_graph.h>

#include <random>
#include <stdexcept>
#include <vector>

namespace livemvs {
namespace {

struct Link {
  int a, b, forth, back;
};

struct Graph {
  int nodes = 0;
  std::vector<Link> links;
  std::vector<std::pair<int, int>> terminals;  // from the source, to the sink
};

Graph RandomGraph(std::mt19937* random, int nodes, int links, int most) {
  Graph graph;
  graph.nodes = nodes;
  const auto number = [&](int below) {
    return static_cast<int>((*random)() % static_cast<unsigned>(below));
  };
  for (int i = 0; i < links; ++i) {
    const int a = number(nodes), b = (a + 1 + number(nodes - 1)) % nodes;
    graph.links.push_back({a, b, number(most), number(most)});
  }
  for (int i = 0; i < nodes; ++i) {
    const bool near_source = number(2) == 0;
    graph.terminals.emplace_back(near_source ? number(2 * most) : number(3),
                                 near_source ? number(3) : number(2 * most));
  }
  return graph;
}

/// Six-linked, of that many nodes each way.
Graph RandomGrid(std::mt19937* random, int side) {
  Graph graph = RandomGraph(random, side * side * side, 0, 100);
  const auto at = [side](int x, int y, int z) { return (z * side + y) * side + x; };
  const auto number = [&] { return static_cast<int>((*random)() % 100); };
  for (int z = 0; z < side; ++z) {
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        if (x > 0) graph.links.push_back({at(x, y, z), at(x - 1, y, z), number(), number()});
        if (y > 0) graph.links.push_back({at(x, y, z), at(x, y - 1, z), number(), number()});
        if (z > 0) graph.links.push_back({at(x, y, z), at(x, y, z - 1), number(), number()});
      }
    }
  }
  return graph;
}

long ValueByLemon(const Graph& graph) {
  lemon::SmartDigraph digraph;
  std::vector<lemon::SmartDigraph::Node> nodes;
  for (int i = 0; i < graph.nodes + 2; ++i) nodes.push_back(digraph.addNode());
  lemon::SmartDigraph::ArcMap<long> capacity(digraph);
  const auto add = [&](int a, int b, int c) {
    capacity[digraph.addArc(nodes[static_cast<std::size_t>(a)],
                            nodes[static_cast<std::size_t>(b)])] = c;
  };
  for (const Link& link : graph.links) {
    add(link.a, link.b, link.forth);
    add(link.b, link.a, link.back);
  }
  for (int i = 0; i < graph.nodes; ++i) {
    add(graph.nodes, i, graph.terminals[static_cast<std::size_t>(i)].first);
    add(i, graph.nodes + 1, graph.terminals[static_cast<std::size_t>(i)].second);
  }
  lemon::Preflow<lemon::SmartDigraph, lemon::SmartDigraph::ArcMap<long>> flow(
      digraph, capacity, nodes[nodes.size() - 2], nodes.back());
  flow.runMinCut();
  return flow.flowValue();
}

template <typename InSource>
long CutValue(const Graph& graph, const InSource& in_source) {
  long value = 0;
  for (const Link& link : graph.links) {
    if (in_source(link.a) && !in_source(link.b)) value += link.forth;
    if (in_source(link.b) && !in_source(link.a)) value += link.back;
  }
  for (int i = 0; i < graph.nodes; ++i) {
    const auto& [source, sink] = graph.terminals[static_cast<std::size_t>(i)];
    value += in_source(i) ? sink : source;
  }
  return value;
}

MinCut MakeCut(const Graph& graph) {
  MinCut cut(static_cast<std::size_t>(graph.nodes), graph.links.size());
  for (const Link& link : graph.links) cut.AddLink(link.a, link.b, link.forth, link.back);
  for (int i = 0; i < graph.nodes; ++i) {
    const auto& [source, sink] = graph.terminals[static_cast<std::size_t>(i)];
    cut.AddTerminal(i, source, sink);
  }
  return cut;
}

/// The cut's value is the least there is, and the sides are a cut of that value.
void ExpectLeast(const Graph& graph, long least) {
  MinCut cut = MakeCut(graph);
  EXPECT_EQ(cut.Solve(), least);
  EXPECT_EQ(CutValue(graph, [&](int i) { return cut.InSource(i); }), least);
}

TEST(MinCut, AgreesWithAllCutsOfSmallGraphs) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 300; ++trial) {
    const Graph graph = RandomGraph(&random, 2 + trial % 9, trial % 30, 20);
    long least = std::numeric_limits<long>::max();
    for (unsigned sides = 0; sides < 1u << graph.nodes; ++sides) {
      least = std::min(least, CutValue(graph, [&](int i) { return ((sides >> i) & 1) != 0; }));
    }
    ExpectLeast(graph, least);
  }
}

TEST(MinCut, AgreesWithLemonOnRandomGraphs) {
  std::mt19937 random(2);
  for (int trial = 0; trial < 100; ++trial) {
    const Graph graph = RandomGraph(&random, 50 + 10 * trial, 3 * (50 + 10 * trial), 1000);
    ExpectLeast(graph, ValueByLemon(graph));
  }
}

TEST(MinCut, AgreesWithLemonOnGrids) {
  std::mt19937 random(3);
  for (const int side : {2, 5, 12, 24}) {
    const Graph graph = RandomGrid(&random, side);
    ExpectLeast(graph, ValueByLemon(graph));
  }
}

TEST(MinCut, CapacitiesOfTerminalsAddUp) {
  MinCut cut(2);
  cut.AddTerminal(0, 5, 0);
  cut.AddTerminal(0, 4, 2);
  cut.AddTerminal(1, 0, 3);
  cut.AddTerminal(1, 1, 10);
  cut.AddLink(0, 1, 100, 0);
  EXPECT_EQ(cut.Solve(), 10);
}

TEST(MinCut, TakesNothingAndRefusesTooMuch) {
  MinCut nothing(0);
  EXPECT_EQ(nothing.Solve(), 0);
  EXPECT_THROW(MinCut(std::size_t{1} << 31), std::invalid_argument);
}

}  // namespace
}  // namespace livemvs
