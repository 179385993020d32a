// cylpose synth: sequences with exact truth.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cylpose/scenario.hpp>
#include <cylpose/sequence.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "commands.hpp"
#include "help_text.hpp"
#include "interrupt.hpp"
#include "output.hpp"
#include "progress.hpp"

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

std::string listing() {
  std::size_t width = 0;
  for (const Scenario& scenario : scenarios()) width = std::max(width, scenario.name.size());
  std::string text;
  for (const Scenario& scenario : scenarios()) {
    text += fmt::format("{:<{}}  {:>3} {}  {}\n", scenario.name, width, scenario.frames,
                        scenario.frames == 1 ? "frame " : "frames", scenario.description);
  }
  return text;
}

void synthesize(const SynthArguments& arguments) {
  const InterruptGuard interrupt;
  const Scenario& scenario = find_scenario(arguments.scenario);
  SequenceOptions options = default_options(scenario);
  options.frames = arguments.frames.value_or(options.frames);
  options.noise_sigma = arguments.noise.value_or(options.noise_sigma);
  options.blur_sigma_px = arguments.blur.value_or(options.blur_sigma_px);
  options.seed = arguments.seed;
  options.video = arguments.video;

  Progress progress(options.frames, false);
  const auto start = std::chrono::steady_clock::now();
  int written = 0;
  const auto files = write_sequence(scenario, options, arguments.output, [&](int done) {
    written = done;
    progress.update(done);
    return !InterruptGuard::requested();
  });
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;

  std::vector<std::string> names;
  names.reserve(files.size());
  for (const auto& file : files) names.push_back(file.filename().string());
  const bool interrupted = written < options.frames;
  progress.message(fmt::format("{}: {} of {} frames, {} in {} ({:.0f} ms a frame){}", scenario.name, written,
                               options.frames, fmt::join(names, ", "), arguments.output.string(),
                               1000 * taken.count() / written,
                               interrupted ? "; interrupted, everything up to here is written" : ""));
  if (interrupted) throw CLI::RuntimeError(kInterrupted);
}

}  // namespace

void add_synth_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("synth", "Render a synthetic sequence with exact truth.");
  set_examples(*command, {"cylpose synth --list", "cylpose synth manipulator --output scene --frames 20"});
  const auto arguments = std::make_shared<SynthArguments>();
  CLI::Option* list = command->add_flag("--list", arguments->list, "Print the scenarios and leave");
  CLI::Option* name =
      command->add_option("SCENARIO", arguments->scenario, "Name of the scenario (--list shows them)")->type_name("");
  CLI::Option* output = command
                            ->add_option("-o,--output", arguments->output,
                                         "Folder for frame_0000.png ..., truth.csv, camera.yaml, parts.yaml")
                            ->type_name("DIR");
  command
      ->add_option("--frames", arguments->frames,
                   "Number of frames (default: the scenario's); the motion stays the same, only its steps change")
      ->type_name("N");
  command->add_option("--noise", arguments->noise, "Sigma of the noise in code values 0..255 (default: the scenario's)")
      ->type_name("SIGMA");
  command->add_option("--blur", arguments->blur, "Sigma of the blur in pixels (default: the scenario's)")
      ->type_name("SIGMA");
  command->add_option("--seed", arguments->seed, fmt::format("Seed of the noise (default: {})", arguments->seed))
      ->type_name("N");
  command->add_flag("--video", arguments->video,
                    "Also write video.mp4 (MPEG-4), or video.avi (Motion JPEG) without that");
  command->callback([=] {
    if (arguments->list) {
      write_stdout(listing());
      return;
    }
    if (name->empty() || output->empty()) {
      throw CLI::RequiredError(name->empty() ? "scenario (or " + list->get_name() + ")" : output->get_name());
    }
    synthesize(*arguments);
  });
}

}  // namespace cylpose::apps
