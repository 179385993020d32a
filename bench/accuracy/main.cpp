// cylpose_accuracy: how near to the truth edges and poses come, and how near they could come. docs/accuracy.md
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cylpose/error.hpp>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <thread>
#include <vector>

#include "location.hpp"
#include "plots.hpp"
#include "pose_outcome.hpp"
#include "pose_summary.hpp"
#include "requirements.hpp"

namespace {

using namespace cylpose;
namespace fs = std::filesystem;

constexpr int kUnusable = 2;
constexpr std::size_t kWorstShown = 10;

struct Arguments {
  bool quick = false;
  int frames = 0;
  std::uint64_t seed = 1;
  fs::path out = "out/accuracy";
  std::vector<std::string> groups = {"location", "poses"};

  [[nodiscard]] bool runs(const std::string& group) const { return std::ranges::find(groups, group) != groups.end(); }
  [[nodiscard]] int random_scenes() const { return frames > 0 ? frames : (quick ? 80 : 1000); }
};

void write_text(const fs::path& path, const std::string& text) {
  std::ofstream stream(path, std::ios::binary);
  stream << text;
  if (!stream.flush()) throw Error(ErrorKind::kOutput, "cannot write " + path.string());
}

void write_picture(const fs::path& path, const cv::Mat& picture) {
  if (!cv::imwrite(path.string(), picture)) throw Error(ErrorKind::kOutput, "cannot write " + path.string());
}

void show_progress(const char* what, std::size_t done, std::size_t all) {
  const std::size_t step = std::max<std::size_t>(1, all / 50);
  if (done % step == 0 || done == all) fmt::print(stderr, "\r{}: {} of {}{}", what, done, all, done == all ? "\n" : "");
}

std::vector<bench::Requirement> locate(const Arguments& arguments) {
  const std::vector<bench::LocationCase> cases = bench::location_cases();
  std::vector<bench::Location> locations;
  for (const bench::LocationCase& one : cases) {
    locations.push_back(bench::measured(one, !arguments.quick));
    show_progress("edge location, cases", locations.size(), cases.size());
  }
  const std::string text = bench::text_of(locations);
  write_text(arguments.out / "location.txt", text);
  write_text(arguments.out / "location.csv", bench::csv_of(locations));
  write_picture(arguments.out / "location.png", bench::location_plot(locations));
  fmt::print("{}\n", text);
  return bench::location_requirements(locations);
}

std::vector<bench::PoseTrial> all_trials(const Arguments& arguments) {
  const int scenes = arguments.random_scenes();
  std::vector<bench::PoseTrial> trials = bench::random_trials(scenes, arguments.seed);
  const auto append = [&](std::vector<bench::PoseTrial> more) {
    trials.insert(trials.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
  };
  append(bench::beyond_trials(std::max(9, scenes / 20), arguments.seed + 1));
  const int frames_each = std::clamp(scenes / 10, 3, 100);
  for (const char* name : {"series1", "series2", "series3", "series4", "manipulator", "occlusion", "candle"}) {
    append(bench::scenario_trials(name, frames_each, arguments.seed));
  }
  return trials;
}

void write_worst(const std::vector<bench::Outcome>& outcomes, const std::vector<bench::PoseTrial>& trials,
                 const fs::path& folder) {
  fs::remove_all(folder);
  fs::create_directories(folder);
  int rank = 0;
  for (const bench::Outcome* outcome : bench::worst(outcomes, kWorstShown)) {
    write_picture(folder / fmt::format("{:02}.png", ++rank), bench::picture_of(*outcome, trials));
  }
}

std::vector<bench::Requirement> estimate(const Arguments& arguments) {
  const std::vector<bench::PoseTrial> trials = all_trials(arguments);
  const auto threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const auto outcomes = bench::run_trials(trials, bench::usual_methods(), threads, [&](std::size_t done) {
    show_progress("poses, scenes", done, trials.size());
  });
  const std::vector<bench::PoseTable> tables = bench::pose_tables(outcomes);
  std::string text;
  for (const bench::PoseTable& table : tables) text += bench::text_of(table) + "\n";
  write_text(arguments.out / "poses.txt", text);
  write_text(arguments.out / "poses.csv", bench::csv_of(outcomes));
  write_text(arguments.out / "poses.json", bench::json_of(tables));
  write_picture(arguments.out / "poses.png", bench::pose_plot(outcomes));
  write_worst(outcomes, trials, arguments.out / "worst");
  fmt::print("{}", text);
  return bench::pose_requirements(outcomes);
}

int run(int argc, char** argv) {
  CLI::App app{"How near to the truth edges and poses come, and how near they could come (docs/accuracy.md)."};
  app.footer("Exit codes: 0 success, whatever was measured; 2 usage, or files that cannot be written.");
  Arguments arguments;
  app.add_flag("--quick", arguments.quick, "fewer scenes and orientations: about a minute");
  app.add_option("--frames", arguments.frames, "random scenes; default 1000, with --quick 80")
      ->check(CLI::Range(1, 1000000));
  app.add_option("--seed", arguments.seed, "of scenes and noise")->capture_default_str();
  app.add_option("--out", arguments.out, "folder for tables, plots and pictures")->capture_default_str();
  app.add_option("groups", arguments.groups, "what to measure: location, poses; default both")
      ->check(CLI::IsMember({"location", "poses"}));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUnusable;
  }
  cv::setNumThreads(1);  // a thread per picture is better used than several in one
  fs::create_directories(arguments.out);
  std::vector<bench::Requirement> requirements;
  if (arguments.runs("location")) requirements = locate(arguments);
  if (arguments.runs("poses")) {
    const auto of_poses = estimate(arguments);
    requirements.insert(requirements.end(), of_poses.begin(), of_poses.end());
  }
  const std::string text = bench::text_of(requirements);
  write_text(arguments.out / "requirements.txt", text);
  fmt::print("{}\n", text);
  fmt::print("Tables, plots and the {} worst frames: {}\n", kWorstShown, arguments.out.string());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "cylpose_accuracy: " << error.what() << '\n';
    return kUnusable;
  }
}
