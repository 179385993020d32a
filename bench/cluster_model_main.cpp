// What the model of the cluster says, beside what was measured (docs/scaling.md).
//
//   cylpose_cluster_model                           a table: frame time and frames a second by nodes, link and tile
//   size cylpose_cluster_model MEASURED.csv PICTURE.png  also the measurements of cylpose_cluster_bench and the model
//   with
//                                                   the constants that were measured with them, in one picture
#include <fmt/format.h>

#include <cylpose/error.hpp>
#include <fstream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>

#include "chart.hpp"
#include "cluster_model.hpp"

namespace {

using namespace cylpose::bench;
using cylpose::Error;
using cylpose::ErrorKind;

constexpr int kTallRows = 240;           // of tiles over links of several rates
constexpr double kSlowMsPerMpixel = 50;  // a small board, or a frame with much more work

void print_table() {
  fmt::print("{:>8} {:>12} {:>6} | {:>10} {:>10} | {:>10} {:>10}\n", "nodes", "link MB/s", "rows", "fast ms",
             "frames/s", "slow ms", "frames/s");
  for (const double link : {12.5, 125.0, 1250.0}) {
    for (const int nodes : {1, 2, 4, 8, 32, 100, 1000}) {
      for (const int rows : {32, 128}) {
        ClusterWorld world;
        world.nodes = nodes;
        world.link_mb_per_s = link;
        world.node_link_mb_per_s = link;
        world.tile_rows = rows;
        ClusterWorld slow = world;
        slow.ms_per_mpixel = kSlowMsPerMpixel;
        fmt::print("{:>8} {:>12} {:>6} | {:>10.2f} {:>10.1f} | {:>10.2f} {:>10.1f}\n", nodes, link, rows,
                   frame_ms(world, 1), 1e3 / frame_ms(world, nodes + 1), frame_ms(slow, 1),
                   1e3 / frame_ms(slow, nodes + 1));
      }
    }
  }
}

// Lines `what,x,value`; constants have no x.
struct Measured {
  std::map<std::string, double> constants;
  std::map<std::string, std::map<double, double>> series;
};

Measured measured_in(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw Error(ErrorKind::kInput, path + ": cannot be read; `scripts/bench cluster` writes it");
  Measured measured;
  for (std::string line; std::getline(file, line);) {
    std::istringstream fields(line);
    std::string what;
    std::string x;
    double value = 0;
    if (!std::getline(fields, what, ',') || !std::getline(fields, x, ',') || !(fields >> value)) {
      throw Error(ErrorKind::kInput, fmt::format("{}: not a line of measurements: {}", path, line));
    }
    if (x.empty()) {
      measured.constants[what] = value;
    } else {
      measured.series[what][std::stod(x)] = value;
    }
  }
  return measured;
}

/// The loopback on which all was measured, seen through the link of the bench.
ClusterWorld measured_world(const Measured& measured) {
  ClusterWorld world;
  const auto constant = [&](const char* name) {
    const auto found = measured.constants.find(name);
    if (found == measured.constants.end()) throw Error(ErrorKind::kInput, std::string("not measured: ") + name);
    return found->second;
  };
  world.node_link_mb_per_s = constant("loopback_mb_per_s");
  world.hop_ms = constant("hop_ms");
  world.tile_ms = constant("tile_ms");
  world.ms_per_mpixel = constant("ms_per_mpixel");
  world.locate_ms = constant("locate_ms");
  return world;
}

template <typename Predict>
Chart compared(std::string title, Axis x, Axis y, const std::map<double, double>& points, const std::vector<double>& at,
               Predict predict) {
  Series model{"model", Mark::kLine, 0, {}};
  for (const double value : at) model.points.emplace_back(value, predict(value));
  Series dots{"measured", Mark::kDots, 4, {}};
  fmt::print("\n{}\n{:>10} {:>10} {:>10} {:>7}\n", title, x.label, "measured", "model", "ratio");
  for (const auto& [value, result] : points) {
    dots.points.emplace_back(value, result);
    fmt::print("{:>10} {:>10.2f} {:>10.2f} {:>7.2f}\n", value, result, predict(value), predict(value) / result);
  }
  return {std::move(title), std::move(x), std::move(y), {model, dots}};
}

std::vector<double> spread(double low, double high) {
  constexpr double kStep = 1.05;
  std::vector<double> values;
  for (double value = low; value < high; value *= kStep) values.push_back(value);
  values.push_back(high);
  return values;
}

Chart node_chart() {
  Chart chart{"model only: 1280x720, nodes of 50 ms/Mpixel, 32 rows a tile",
              {"nodes", 1, 1000, true, {}},
              {"ms", 1, 1000, true, {}},
              {}};
  std::size_t color = 0;
  for (const double link : {12.5, 125.0, 1250.0}) {
    Series series{fmt::format("{:g} Gb/s", link * 8e-3), Mark::kLine, color++, {}};
    for (const double nodes : spread(1, 1000)) {
      ClusterWorld world;
      world.nodes = static_cast<int>(nodes);
      world.link_mb_per_s = link;
      world.node_link_mb_per_s = link;
      world.ms_per_mpixel = kSlowMsPerMpixel;
      world.tile_rows = 32;
      series.points.emplace_back(world.nodes, frame_ms(world, 1));
    }
    chart.series.push_back(series);
  }
  return chart;
}

std::vector<Chart> charts(Measured measured) {
  const ClusterWorld world = measured_world(measured);
  std::vector<Chart> all;
  all.push_back(compared("1280x720 by one worker, link of the coordinator throttled", {"MB/s", 10, 300, true, {}},
                         {"ms", 5, 400, true, {}}, measured.series["link"], spread(10, 300), [&](double link) {
                           ClusterWorld at = world;
                           at.link_mb_per_s = link;
                           at.tile_rows = kTallRows;
                           return frame_ms(at, 1);
                         }));
  all.push_back(compared("1280x720 by one worker at 50 MB/s", {"rows a tile", 16, 300, true, {}},
                         {"ms", 50, 100, false, {}}, measured.series["rows"], spread(16, 300), [&](double rows) {
                           ClusterWorld at = world;
                           at.link_mb_per_s = 50;
                           at.tile_rows = static_cast<int>(rows);
                           return frame_ms(at, 1);
                         }));
  if (const auto& rates = measured.series["rate"]; rates.contains(1)) {
    const double most = 10 * rates.at(1);
    all.push_back(compared("640x400, workers held to a share of a core", {"nodes", 0, 9, false, {}},
                           {"frames/s", 0, most, false, {}}, rates, {1, 2, 3, 4, 5, 6, 7, 8}, [&](double nodes) {
                             ClusterWorld at = world;
                             at.link_mb_per_s = world.node_link_mb_per_s;
                             at.width = 640;
                             at.height = 400;
                             at.nodes = static_cast<int>(nodes);
                             at.tile_rows = std::max(32, static_cast<int>(400 / nodes));
                             // One node's rate says how slow it is; the others are predicted from that.
                             at.ms_per_mpixel = measured.constants["held_ms_per_mpixel"];
                             return 1e3 / frame_ms(at, at.nodes + 1);
                           }));
  }
  all.push_back(node_chart());
  return all;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc != 1 && argc != 3)
      throw Error(ErrorKind::kInput, "usage: cylpose_cluster_model [MEASURED.csv PICTURE.png]");
    print_table();
    if (argc == 3 && !cv::imwrite(argv[2], drawn(charts(measured_in(argv[1])), 2))) {
      throw Error(ErrorKind::kOutput, std::string(argv[2]) + ": cannot be written");
    }
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "cylpose_cluster_model: {}\n", error.what());
    return 1;
  }
}
