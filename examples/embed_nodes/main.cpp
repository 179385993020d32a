// cylpose's nodes between nodes of your own, in a oneTBB flow graph of your own.
//   embed_nodes camera.yaml parts.yaml images...
//
//   files -> limiter -> detect -> [count edges] -> solve -> order -> print
//               ^                                                      |
//               +------------------- one more may enter ---------------+
#include <oneapi/tbb/flow_graph.h>

#include <atomic>
#include <cstdio>
#include <cylpose/default_backend.hpp>
#include <cylpose/graph/nodes.hpp>
#include <string>
#include <vector>

using cylpose::graph::FramePtr;

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "usage: %s camera.yaml parts.yaml images...\n", argv[0]);
    return 2;
  }
  try {
    const cylpose::CameraModel camera = cylpose::load_camera(argv[1]);
    const std::vector<cylpose::PartModel> parts = cylpose::load_parts(argv[2]);
    const auto backend = cylpose::make_default_backend().backend;
    const auto solver = std::make_shared<const cylpose::PoseSolver>(camera, parts);
    cylpose::DetectOptions options;
    options.transfer = camera.transfer;
    std::atomic<std::size_t> edges = 0;
    int found = 0;

    tbb::flow::graph graph;
    cylpose::graph::SourceNode files(graph, cylpose::open_frames(std::vector<std::string>(argv + 3, argv + argc)));
    tbb::flow::limiter_node<FramePtr> limiter(graph, 4);
    cylpose::graph::DetectNode detect(graph, *backend, parts, options);
    tbb::flow::function_node<FramePtr, FramePtr> count(graph, tbb::flow::unlimited, [&](const FramePtr& frame) {
      for (const cylpose::PartEdges& part : frame->field.parts) edges += part.edges.size();
      return frame;
    });
    cylpose::graph::SolveNode solve(graph, solver, tbb::flow::unlimited);
    cylpose::graph::OrderNode order(graph);
    cylpose::graph::SinkNode print(graph, [&](const FramePtr& frame) {
      const cylpose::PoseEstimate& part = frame->estimate.parts.front();
      found += part.status == cylpose::PoseStatus::kOk ? 1 : 0;
      std::printf("%s: %s\n", frame->name.c_str(), std::string(to_string(part.status)).c_str());
    });

    make_edge(files, limiter);
    make_edge(limiter, detect);
    make_edge(detect, count);
    make_edge(count, solve);
    make_edge(solve, order);
    make_edge(order, print);
    make_edge(print, limiter.decrementer());
    files.activate();
    graph.wait_for_all();
    std::printf("%d found, %zu edge pixels\n", found, edges.load());
    return found > 0 ? 0 : 1;
  } catch (const cylpose::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
