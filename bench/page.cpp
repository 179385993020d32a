#include "page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cylpose/html_page.hpp>
#include <nlohmann/json.hpp>

#include "figures.hpp"
#include "page_files.hpp"

namespace cylpose::bench {
namespace {

std::string heads(const std::vector<std::string>& texts) {
  std::string row = "<tr>";
  for (const std::string& text : texts) row += fmt::format("<th scope=\"col\">{}</th>", html_escaped(text));
  return row + "</tr>\n";
}

std::string row_of(const std::string& head, const std::vector<std::string>& texts) {
  std::string row = fmt::format("<tr><th scope=\"row\">{}</th>", html_escaped(head));
  for (const std::string& text : texts) row += fmt::format("<td>{}</td>", html_escaped(text));
  return row + "</tr>\n";
}

std::string label_of(const CaseRow& row) {
  return row.scene + " " + row.size;
}

std::string times_html(const BenchRun& run, const CaseGrid& grid) {
  std::vector<std::string> columns{"Median [ms]"};
  columns.insert(columns.end(), grid.backends.begin(), grid.backends.end());
  columns.emplace_back("reading");
  std::string body;
  for (const CaseRow& row : grid.rows) {
    std::vector<std::string> cells;
    for (const Measured* cell : row.by_backend) cells.push_back(number_text(median_time(cell), 3));
    cells.push_back(number_text(read_time(run, row), 4));
    const std::vector<std::optional<double>> all = ratios(grid, row);
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (grid.backends[i] == kYardstick) continue;
      cells.push_back(number_text(all[i], 1));
      if (&row == &grid.rows.front()) columns.push_back(fmt::format("{} / {}", grid.backends[i], kYardstick));
    }
    body += row_of(label_of(row), cells);
  }
  return html_table("Time of a frame by scene, size and backend; how many times longer than " +
                        std::string(kYardstick) + "; reading: the pixels once, at this machine's bandwidth",
                    heads(columns), body);
}

std::string color_of(const std::vector<std::string>& names, const std::string& stage) {
  constexpr std::ptrdiff_t kColors = 16;  // in page.css
  return fmt::format("stage-{}", (std::ranges::find(names, stage) - names.begin()) % kColors);
}

std::string legend_html(const std::vector<std::string>& names) {
  std::string html = "<ul class=\"legend\">\n";
  for (const std::string& name : names) {
    html += fmt::format("<li class=\"{}\">{}</li>\n", color_of(names, name), html_escaped(name));
  }
  return html + "<li class=\"between\">between stages</li>\n<li class=\"limit\">reading</li>\n</ul>\n";
}

double length_of(const Measured& cell) {
  double staged = 0;
  for (const Stage& stage : stages_of(cell)) staged += stage.milliseconds;
  return std::max(staged, median(cell.milliseconds));
}

// One group of bars; its longest takes the whole width.
std::string bars_html(const BenchRun& run, const CaseGrid& grid, const CaseRow& row,
                      const std::vector<std::string>& names) {
  double longest = 0;
  for (const Measured* cell : row.by_backend) longest = cell == nullptr ? longest : std::max(longest, length_of(*cell));
  const auto box = [longest](const std::string& kind, double from_ms, double ms) {
    return fmt::format("<div class=\"{}\" style=\"left:{:.3f}%;width:{:.3f}%\"></div>", kind, 100 * from_ms / longest,
                       100 * ms / longest);
  };
  std::string html =
      fmt::format("<figure>\n<figcaption>{} {}</figcaption>\n<div class=\"bars\" aria-hidden=\"true\">\n", grid.kind,
                  html_escaped(label_of(row)));
  const std::optional<double> reading = read_time(run, row);
  for (std::size_t i = 0; i < grid.backends.size(); ++i) {
    const Measured* cell = row.by_backend[i];
    if (cell == nullptr) continue;
    const double total = median(cell->milliseconds);
    std::string boxes = box("between", 0, total);
    double from = 0;
    for (const Stage& stage : stages_of(*cell)) {
      boxes += box(color_of(names, stage.name), from, stage.milliseconds);
      from += stage.milliseconds;
    }
    if (reading) boxes += fmt::format("<div class=\"limit\" style=\"left:{:.3f}%\"></div>", 100 * *reading / longest);
    html += fmt::format("<span>{}</span><div class=\"track\">{}</div><span>{:.3f} ms</span>\n",
                        html_escaped(grid.backends[i]), boxes, total);
  }
  return html + "</div>\n</figure>\n";
}

std::string stages_html(const CaseGrid& grid, const std::vector<std::string>& names) {
  std::vector<std::string> columns{"Stage [ms]"};
  columns.insert(columns.end(), names.begin(), names.end());
  std::string body;
  for (const CaseRow& row : grid.rows) {
    for (std::size_t i = 0; i < grid.backends.size(); ++i) {
      if (row.by_backend[i] == nullptr) continue;
      const std::vector<Stage> stages = stages_of(*row.by_backend[i]);
      std::vector<std::string> cells;
      for (const std::string& name : names) {
        const auto stage = std::ranges::find(stages, name, &Stage::name);
        cells.push_back(stage == stages.end() ? "-" : number_text(stage->milliseconds, 3));
      }
      body += row_of(label_of(row) + " " + grid.backends[i], cells);
    }
  }
  return html_table("Milliseconds in each stage", heads(columns), body);
}

std::string grid_html(const BenchRun& run, const CaseGrid& grid, const std::string& title) {
  if (grid.rows.empty()) return {};
  const std::vector<std::string> names = stage_names({grid});
  std::string bars;
  for (const CaseRow& row : grid.rows) bars += bars_html(run, grid, row, names);
  return fmt::format("<section>\n<h2>{}</h2>\n{}{}<div class=\"cases\">\n{}</div>\n{}</section>\n", title,
                     times_html(run, grid), legend_html(names), bars, stages_html(grid, names));
}

std::string others_html(const BenchRun& run) {
  std::string body;
  for (const Measured& benchmark : run.benchmarks) {
    if (parsed_case(benchmark.name)) continue;
    body += row_of(benchmark.name,
                   {number_text(median_time(&benchmark), 4), number_text(median_counter(benchmark, "GB/s"), 1)});
  }
  if (body.empty()) return {};
  return "<section>\n<h2>Others</h2>\n" +
         html_table("Medians of all other benchmarks", heads({"Benchmark", "ms", "GB/s"}), body) + "</section>\n";
}

std::string data_of(const BenchRun& run) {
  using Json = nlohmann::ordered_json;
  Json benchmarks = Json::array();
  for (const Measured& benchmark : run.benchmarks) {
    Json counters = Json::object();
    for (const auto& [counter, values] : benchmark.counters) counters[counter] = median(values);
    benchmarks.push_back({{"name", benchmark.name},
                          {"median_ms", median(benchmark.milliseconds)},
                          {"milliseconds", benchmark.milliseconds},
                          {"counters", std::move(counters)}});
  }
  const Json json{{"context", run.context}, {"benchmarks", std::move(benchmarks)}};
  return html_data_block(json.dump(-1, ' ', true, Json::error_handler_t::replace));
}

}  // namespace

std::string page_of(const BenchRun& run) {
  HtmlPage page;
  page.title = "Bench of cylpose";
  for (const auto& [key, value] : run.context) {
    if (is_of_machine(key)) page.facts.push_back({key, value});
  }
  page.css = page_files::page_css();
  page.main = grid_html(run, grid_of(run, "detect"), "From a frame to its edges") +
              grid_html(run, grid_of(run, "estimate"), "From a frame to its poses") + others_html(run);
  page.footer = ". Medians of all repetitions; only ratios within one run mean anything.";
  page.scripts = data_of(run);
  return to_html(page);
}

}  // namespace cylpose::bench
