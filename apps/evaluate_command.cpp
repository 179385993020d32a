#include <fmt/format.h>

#include <cylpose/evaluate.hpp>
#include <cylpose/pose_io.hpp>
#include <memory>
#include <string>

#include "commands.hpp"
#include "output.hpp"

namespace cylpose::apps {
namespace {

struct Arguments {
  std::string truth;
  std::string poses;
  std::string json;
  EvaluateOptions options;
};

void evaluate_files(const Arguments& arguments) {
  const Evaluation evaluation = evaluate(load_truth(arguments.truth), load_poses(arguments.poses), arguments.options);
  for (const std::string& warning : evaluation.warnings()) fmt::print(stderr, "cylpose: warning: {}\n", warning);
  if (!arguments.json.empty()) write_result(arguments.json, to_json(evaluation));
  if (arguments.json != "-") write_stdout(to_text(evaluation));
}

}  // namespace

void add_evaluate_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("evaluate", "Compare poses with the truth: found rate, errors, wrong poses.");
  const auto arguments = std::make_shared<Arguments>();
  command->add_option("truth", arguments->truth, "Truth: CSV with the columns frame,cx,cy,cz,ax,ay,az[,part]")
      ->required()
      ->type_name("TRUTH.csv");
  command->add_option("poses", arguments->poses, "Poses: CSV or JSON lines, as `cylpose estimate` writes them")
      ->required()
      ->type_name("POSES.csv");
  command->add_option("--json", arguments->json, "Also write the result as JSON; - writes it, and no table, to stdout")
      ->type_name("FILE|-");
  command->add_option("--part", arguments->options.part, "Compare this part only")->type_name("NAME");
  command->callback([arguments] { evaluate_files(*arguments); });
}

}  // namespace cylpose::apps
