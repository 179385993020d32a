// cylpose synth: sequences with exact truth.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cylpose/scenario.hpp>
#include <cylpose/sequence.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "commands.hpp"

namespace cylpose::apps {
namespace {

struct SynthArguments {
  std::string scenario;
  std::filesystem::path output;
  std::optional<int> frames;
  std::optional<double> noise;
  std::optional<double> blur;
  std::uint64_t seed = 1;
  bool video = false;
  bool list = false;
};

void list_scenarios() {
  std::size_t width = 0;
  for (const Scenario& scenario : scenarios()) width = std::max(width, scenario.name.size());
  for (const Scenario& scenario : scenarios()) {
    fmt::print("{:<{}}  {:>3} {}  {}\n", scenario.name, width, scenario.frames,
               scenario.frames == 1 ? "frame " : "frames", scenario.description);
  }
}

void synthesize(const SynthArguments& arguments) {
  const Scenario& scenario = find_scenario(arguments.scenario);
  SequenceOptions options = default_options(scenario);
  options.frames = arguments.frames.value_or(options.frames);
  options.noise_sigma = arguments.noise.value_or(options.noise_sigma);
  options.blur_sigma_px = arguments.blur.value_or(options.blur_sigma_px);
  options.seed = arguments.seed;
  options.video = arguments.video;

  const bool on_terminal = isatty(STDERR_FILENO) == 1;
  const auto start = std::chrono::steady_clock::now();
  const auto files = write_sequence(scenario, options, arguments.output, [&](int done) {
    if (on_terminal) fmt::print(stderr, "\r{}: frame {} of {}", scenario.name, done, options.frames);
    return true;
  });
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  if (on_terminal) fmt::print(stderr, "\n");

  fmt::print("{}: {} frame{} in {} ({:.0f} ms a frame)\n", scenario.name, options.frames,
             options.frames == 1 ? "" : "s", arguments.output.string(), 1000 * taken.count() / options.frames);
  for (const auto& file : files) fmt::print("  {}\n", file.filename().string());
}

}  // namespace

void add_synth_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("synth", "Render a synthetic sequence with exact truth");
  const auto arguments = std::make_shared<SynthArguments>();
  CLI::Option* list = command->add_flag("--list", arguments->list, "Print the scenarios and leave");
  CLI::Option* name = command->add_option("scenario", arguments->scenario, "Name of the scenario (--list shows them)");
  CLI::Option* output = command->add_option("-o,--output", arguments->output,
                                            "Folder for frame_0000.png ..., truth.csv, camera.yaml, parts.yaml");
  command->add_option("--frames", arguments->frames,
                      "Number of frames; the motion stays the same, only its steps change");
  command->add_option("--noise", arguments->noise, "Sigma of the noise in code values 0..255");
  command->add_option("--blur", arguments->blur, "Sigma of the blur in pixels");
  command->add_option("--seed", arguments->seed, "Seed of the noise")->capture_default_str();
  command->add_flag("--video", arguments->video,
                    "Also write video.mp4 (MPEG-4), or video.avi (Motion JPEG) without that");
  command->callback([=] {
    if (arguments->list) {
      list_scenarios();
      return;
    }
    if (name->empty() || output->empty()) {
      throw CLI::RequiredError(name->empty() ? "scenario (or " + list->get_name() + ")" : output->get_name());
    }
    synthesize(*arguments);
  });
}

}  // namespace cylpose::apps
