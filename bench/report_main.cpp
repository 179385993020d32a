// cylpose_bench_report: tables, pictures and pages from the files that cylpose_bench writes.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cylpose/error.hpp>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "comparison.hpp"
#include "page.hpp"
#include "results.hpp"
#include "stage_picture.hpp"
#include "table.hpp"

namespace {

using namespace cylpose;
namespace fs = std::filesystem;

constexpr int kSlower = 1;
constexpr int kUnusable = 2;

struct RunArguments {
  fs::path run;
  fs::path table;
  fs::path picture;
  fs::path report;
};

struct CompareArguments {
  std::vector<fs::path> old_files;
  std::vector<fs::path> new_files;
};

void write_text(const fs::path& path, const std::string& text) {
  std::ofstream stream(path, std::ios::binary);
  stream << text;
  if (!stream.flush()) throw Error(ErrorKind::kOutput, "cannot write " + path.string());
}

void report(const RunArguments& arguments) {
  const bench::BenchRun run = bench::load_run(arguments.run);
  const std::string table = bench::table_of(run);
  write_text(arguments.table, table);
  if (!cv::imwrite(arguments.picture.string(), bench::stage_picture(run))) {
    throw Error(ErrorKind::kOutput, "cannot write " + arguments.picture.string());
  }
  if (!arguments.report.empty()) write_text(arguments.report, bench::page_of(run));
  fmt::print("{}", table);
}

std::vector<bench::BenchRun> loaded(const std::vector<fs::path>& files) {
  std::vector<bench::BenchRun> runs;
  runs.reserve(files.size());
  for (const fs::path& file : files) runs.push_back(bench::load_run(file));
  return runs;
}

int compare(const CompareArguments& arguments) {
  const std::vector<bench::Change> changes = bench::changes(loaded(arguments.old_files), loaded(arguments.new_files));
  if (changes.empty()) throw Error(ErrorKind::kInput, "the two revisions have no benchmark in common");
  fmt::print("{}", bench::text_of(changes));
  const auto slower = std::ranges::count_if(changes, &bench::Change::is_slower);
  fmt::print("\n{} of {} benchmarks are slower: even the best new run took longer than the worst old one\n", slower,
             changes.size());
  return slower == 0 ? 0 : kSlower;
}

int run(int argc, char** argv) {
  CLI::App app{"Tables, pictures and pages from the files that cylpose_bench writes."};
  app.require_subcommand(1);
  app.footer("Exit codes: 0 success, 1 slower, 2 usage, or a file that cannot be used.");

  RunArguments one;
  CLI::App* run_command = app.add_subcommand("run", "One run as text, as a picture and as a page.");
  run_command->add_option("RUN", one.run, "JSON of cylpose_bench")->required();
  run_command->add_option("--table", one.table, "text file to write")->required();
  run_command->add_option("--picture", one.picture, "picture to write")->required();
  run_command->add_option("--report", one.report, "HTML page to write");

  CompareArguments both;
  CLI::App* compare_command = app.add_subcommand("compare", "Two revisions; fails where the new one is surely slower.");
  compare_command->add_option("--old", both.old_files, "JSON files of the old revision")->required();
  compare_command->add_option("--new", both.new_files, "JSON files of the new revision")->required();

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUnusable;
  }
  if (compare_command->parsed()) return compare(both);
  report(one);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "cylpose_bench_report: " << error.what() << '\n';
    return kUnusable;
  }
}
