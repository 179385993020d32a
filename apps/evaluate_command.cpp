#include <fmt/format.h>

#include <cylpose/evaluate.hpp>
#include <cylpose/pose_io.hpp>
#include <cylpose/report.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "commands.hpp"
#include "help_text.hpp"
#include "output.hpp"

namespace cylpose::apps {
namespace {

struct Arguments {
  std::string truth;
  std::string poses;
  std::string json;
  std::string report;
  EvaluateOptions options;
};

void write_report(const Arguments& arguments, std::vector<TruthRow> truth, std::vector<PoseRow> poses) {
  const std::string& part = arguments.options.part;
  if (!part.empty()) {
    std::erase_if(poses, [&](const PoseRow& row) { return row.part != part; });
    std::erase_if(truth, [&](const TruthRow& row) { return !row.part.empty() && row.part != part; });
  }
  Report report;
  report.title = fmt::format("{} compared with the truth", arguments.poses);
  report.facts = {{"Poses", arguments.poses}, {"Truth", arguments.truth}};
  report.poses = std::move(poses);
  report.truth = std::move(truth);
  write_result(arguments.report, to_html(report));
}

void evaluate_files(const Arguments& arguments) {
  const std::vector<TruthRow> truth = load_truth(arguments.truth);
  const std::vector<PoseRow> poses = load_poses(arguments.poses);
  const Evaluation evaluation = evaluate(truth, poses, arguments.options);
  for (const std::string& warning : evaluation.warnings()) fmt::print(stderr, "cylpose: warning: {}\n", warning);
  if (!arguments.json.empty()) write_result(arguments.json, to_json(evaluation));
  if (!arguments.report.empty()) write_report(arguments, truth, poses);
  if (arguments.json != "-") write_stdout(to_text(evaluation));
}

}  // namespace

void add_evaluate_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("evaluate", "Compare poses with the truth: found rate, errors, wrong poses.");
  set_examples(*command, {"cylpose evaluate truth.csv poses.csv",
                          "cylpose evaluate truth.csv poses.csv --json result.json --report report.html"});
  const auto arguments = std::make_shared<Arguments>();
  command
      ->add_option("TRUTH", arguments->truth,
                   "CSV with the columns frame,cx,cy,cz,ax,ay,az[,part]; metres, in the frame of the poses")
      ->required()
      ->type_name("TRUTH.csv");
  command->add_option("POSES", arguments->poses, "CSV or JSON lines, as `cylpose estimate` writes them")
      ->required()
      ->type_name("POSES.csv");
  command->add_option("--json", arguments->json, "Also write the result as JSON; - writes it, and no table, to stdout")
      ->type_name("FILE|-");
  command->add_option("--report", arguments->report, "Also write a page with tables and plots")->type_name("FILE.html");
  command->add_option("--part", arguments->options.part, "Compare this part only (default: all)")->type_name("NAME");
  command->callback([arguments] { evaluate_files(*arguments); });
}

}  // namespace cylpose::apps
