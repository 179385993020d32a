#include <fmt/format.h>

#include <cylpose/cluster/archive.hpp>
#include <cylpose/error.hpp>
#include <cylpose/frame_source.hpp>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>

#include "cluster_commands.hpp"
#include "cluster_options.hpp"
#include "commands.hpp"
#include "help_text.hpp"
#include "interrupt.hpp"
#include "output.hpp"

namespace cylpose::apps {
namespace {

struct Arguments {
  ClusterArguments connection;
  std::string camera;
  std::string parts;
  std::string format = "csv";
  std::vector<std::string> inputs;
  cluster::Archive archive;
};

std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) throw Error(ErrorKind::kInput, path + ": cannot be read");
  return text.str();
}

void submit(const Arguments& arguments) {
  // Both are looked at here, where the user is, and not first on a worker.
  static_cast<void>(load_camera(arguments.camera));
  static_cast<void>(load_parts(arguments.parts));
  const auto format = pose_format_from(arguments.format);
  if (!format) throw Error(ErrorKind::kInput, fmt::format("--format {}: write csv, jsonl or tum", arguments.format));
  cluster::Archive archive = arguments.archive;
  archive.camera_yaml = text_of(arguments.camera);
  archive.parts_yaml = text_of(arguments.parts);
  archive.format = *format;
  for (const std::string& file : image_files(arguments.inputs)) {
    archive.files.push_back(std::filesystem::absolute(file).string());
  }
  const std::int64_t jobs = cluster::submit_archive(connection_options(arguments.connection), archive);
  tell_user(fmt::format("{} frames in {} jobs; `cylpose collect {}` gathers the poses", archive.files.size(), jobs,
                        archive.name));
}

void collect(const Arguments& arguments) {
  const InterruptGuard interrupt;
  cluster::collect_archive(connection_options(arguments.connection), arguments.archive.name, write_stdout,
                           InterruptGuard::requested);
  if (InterruptGuard::requested()) throw CLI::RuntimeError(kInterrupted);
}

}  // namespace

void add_archive_commands(CLI::App& app) {
  CLI::App* command = app.add_subcommand("submit", "Queue a recording for `cylpose worker --jobs`.");
  set_examples(*command,
               {"cylpose submit --server nats://HOST:4222 --name flight7 --camera camera.yaml --parts parts.yaml "
                "frames/"});
  const auto arguments = std::make_shared<Arguments>();
  add_connection_options(*command, arguments->connection);
  command->add_option("--camera", arguments->camera, "Calibration, as for `cylpose estimate`")
      ->required()
      ->type_name("FILE");
  command->add_option("--parts", arguments->parts, "The cylinders, as for `cylpose estimate`")
      ->required()
      ->type_name("FILE");
  command->add_option("--name", arguments->archive.name, "What to call it; the same again goes on where it stopped")
      ->required()
      ->type_name("NAME");
  command->add_option("--format", arguments->format, "Form of the poses (default: csv)")->type_name("csv|jsonl|tum");
  command->add_option("--fps", arguments->archive.fps, "Frames per second (default: 30)")->type_name("NUMBER");
  command->add_option("--job-frames", arguments->archive.frames_per_job, "Frames of a job (default: 16)")
      ->type_name("N");
  command->add_flag("--upload", arguments->archive.upload, "Put the images into the server: workers need no files");
  command
      ->add_option("INPUT", arguments->inputs,
                   "Images, folders and patterns; without --upload by paths that workers can open")
      ->required()
      ->type_name("...");
  command->callback([arguments] { submit(*arguments); });

  CLI::App* gather = app.add_subcommand(
      "collect", "Write the poses of a submitted recording in order; waits for those still to come.");
  set_examples(*gather, {"cylpose collect --server nats://HOST:4222 flight7 > poses.csv"});
  const auto wanted = std::make_shared<Arguments>();
  add_connection_options(*gather, wanted->connection);
  gather->add_option("NAME", wanted->archive.name, "As given to `cylpose submit`")->required()->type_name("");
  gather->callback([wanted] { collect(*wanted); });
}

}  // namespace cylpose::apps
